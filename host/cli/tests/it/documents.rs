//! Checks that the commands of documents print what stands below them, and write the pictures that are shown.

use std::path::Path;
use std::{env, fs};

use crate::common::folder;

#[path = "../../../examples/moving_picture.rs"]
#[allow(dead_code, reason = "its `main` draws other pictures")]
mod moving_picture;

/// The command that draws the picture of a step, without its arguments.
const PICTURE: &str = "cargo run --release --example moving_picture -- ";

/// Returns the words of a command, given that quotation marks hold some together.
fn words(line: &str) -> Vec<String> {
    let parts = line.split('"').enumerate();
    let words = parts.flat_map(|(number, part)| {
        let quoted = number % 2 == 1;
        let words: Vec<String> = match quoted {
            true => vec![part.into()],
            false => part.split_whitespace().map(String::from).collect(),
        };
        words
    });
    words.collect()
}

/// Returns a text without the lines that tell times.
fn timeless(text: &str) -> String {
    let lines = text.lines().filter(|line| !line.starts_with("  time "));
    lines.map(|line| format!("{line}\n")).collect()
}

/// Runs the commands of a page in an empty folder with these files of its pictures, and compares what they print and draw.
/// With `FOLDPATH_GENERATE` the page gets what is printed, and its folder the pictures.
fn runs_as_it_says(name: &str, given: &[&str]) {
    let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs");
    let (file, shown) = (docs.join(format!("{name}.md")), docs.join(name));
    let page = fs::read_to_string(&file).unwrap();
    let folder = folder();
    for picture in given {
        folder.write(picture, &fs::read_to_string(shown.join(picture)).unwrap());
    }
    let mut pictures: Vec<String> = given.iter().map(ToString::to_string).collect();
    let mut fresh = String::new();
    for (number, part) in page.split("```").enumerate() {
        fresh += if number == 0 { "" } else { "```" };
        let Some(block) = part.strip_prefix("console\n") else {
            fresh += part;
            continue;
        };
        fresh += "console\n";
        for run in block.split("$ ").skip(1) {
            let line = run.lines().next().unwrap();
            let printed = if let Some(arguments) = line.strip_prefix(PICTURE) {
                let [path, step, _, picture] = &words(arguments)[..] else {
                    panic!("{line}");
                };
                let step = step.parse().unwrap();
                let drawn = moving_picture::picture_of_step(&folder.path(path), step).unwrap();
                folder.write(picture, &drawn);
                String::new()
            } else {
                let answer = folder
                    .command("")
                    .args(words(line.strip_prefix("foldpath ").unwrap()))
                    .output()
                    .unwrap();
                timeless(&String::from_utf8([answer.stdout, answer.stderr].concat()).unwrap())
            };
            fresh += &format!("$ {line}\n{printed}");
            let written = words(line).pop().filter(|name| name.ends_with(".svg"));
            pictures.extend(written);
        }
    }
    if env::var_os("FOLDPATH_GENERATE").is_some() {
        fs::write(&file, &fresh).unwrap();
        for picture in &pictures {
            fs::write(shown.join(picture), folder.read(picture)).unwrap();
        }
        return;
    }
    assert_eq!(fresh, page);
    let kept = fs::read_dir(&shown).unwrap();
    let kept = kept.map(|entry| entry.unwrap().file_name().into_string().unwrap());
    let mut kept: Vec<String> = kept.collect();
    kept.sort_unstable();
    pictures.sort_unstable();
    pictures.dedup();
    assert_eq!(kept, pictures, "each picture has its command");
    for picture in kept {
        let fresh = folder.read(&picture);
        let known = fs::read_to_string(shown.join(&picture)).unwrap();
        assert!(fresh == known, "{picture}");
        let is_shown = page.contains(&format!("{name}/{picture}"));
        assert!(is_shown, "{picture} is shown");
    }
}

#[test]
fn the_carton_is_as_its_commands_print_and_draw_it() {
    runs_as_it_says("carton", &["carton.svg"]);
}

#[test]
fn the_tutorial_is_as_its_commands_print_and_draw_it() {
    runs_as_it_says("tutorial", &["map.svg"]);
}

#[test]
fn the_plates_are_as_their_commands_print_and_draw_them() {
    runs_as_it_says("plates", &["board.svg"]);
}

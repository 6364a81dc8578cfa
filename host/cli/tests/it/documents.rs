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

#[test]
fn the_carton_is_as_its_commands_print_and_draw_it() {
    let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs");
    let page = fs::read_to_string(docs.join("carton.md")).unwrap();
    let folder = folder();
    folder.write(
        "carton.svg",
        &fs::read_to_string(docs.join("carton/carton.svg")).unwrap(),
    );
    let blocks = page.split("```console\n").skip(1);
    let blocks = blocks.map(|block| block.split("```").next().unwrap());
    let mut pictures = vec!["carton.svg".to_string()];
    for run in blocks.flat_map(|block| block.split("$ ").skip(1)) {
        let (line, printed) = run.split_once('\n').unwrap();
        if let Some(arguments) = line.strip_prefix(PICTURE) {
            let [path, step, _, picture] = &words(arguments)[..] else {
                panic!("{line}");
            };
            let step = step.parse().unwrap();
            let drawn = moving_picture::picture_of_step(&folder.path(path), step).unwrap();
            folder.write(picture, &drawn);
        } else {
            let answer = folder
                .command("")
                .args(words(line.strip_prefix("foldpath ").unwrap()))
                .output()
                .unwrap();
            let said = [answer.stdout, answer.stderr].concat();
            assert_eq!(
                timeless(&String::from_utf8(said).unwrap()),
                printed,
                "{line}"
            );
        }
        let written = words(line).pop().filter(|name| name.ends_with(".svg"));
        pictures.extend(written);
    }
    let shown = docs.join("carton");
    if env::var_os("FOLDPATH_GENERATE").is_some() {
        for picture in &pictures {
            fs::write(shown.join(picture), folder.read(picture)).unwrap();
        }
    }
    let kept = fs::read_dir(&shown).unwrap();
    let kept = kept.map(|entry| entry.unwrap().file_name().into_string().unwrap());
    let mut kept: Vec<String> = kept.collect();
    kept.sort_unstable();
    pictures.sort_unstable();
    assert_eq!(kept, pictures, "each picture has its command");
    for picture in kept {
        let fresh = folder.read(&picture);
        assert!(
            fresh == fs::read_to_string(shown.join(&picture)).unwrap(),
            "{picture}"
        );
        assert!(
            page.contains(&format!("carton/{picture}")),
            "{picture} is shown"
        );
    }
}

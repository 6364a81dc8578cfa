//! Checks that the commands of the README in `patterns/` write its files and pictures, byte for byte.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use std::process::Command;

#[test]
fn each_is_what_its_command_writes() {
    let patterns = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../patterns");
    let readme = fs::read_to_string(patterns.join("README.md")).expect("patterns/README.md");
    let fresh = tempfile::tempdir().unwrap();
    let mut written = BTreeSet::new();
    for line in readme
        .lines()
        .filter(|l| l.starts_with("foldpath generate "))
    {
        let (arguments, name) = line
            .rsplit_once(" -o ")
            .expect("-o NAME at the end of the line");
        let name = name.rsplit('/').next().unwrap();
        let run = Command::new(env!("CARGO_BIN_EXE_foldpath"))
            .args(arguments.split_whitespace().skip(1))
            .arg("-o")
            .arg(fresh.path().join(name))
            .output()
            .expect("foldpath starts");
        assert!(
            run.status.success(),
            "{line}: {}",
            String::from_utf8_lossy(&run.stderr)
        );
        let [fresh, kept] = [fresh.path(), &patterns].map(|folder| fs::read(folder.join(name)));
        assert!(
            fresh.unwrap() == kept.expect(name),
            "{name} is not what `{line}` writes"
        );
        written.insert(name.to_owned());
    }
    let kept = fs::read_dir(&patterns)
        .unwrap()
        .map(|entry| entry.unwrap().file_name());
    let kept = kept.map(|name| name.into_string().unwrap());
    let kept: BTreeSet<String> = kept.filter(|name| name.ends_with(".fold")).collect();
    assert_eq!(written, kept, "each file has its command in README.md");
}

#[test]
fn each_has_its_picture() {
    let patterns = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../patterns");
    let readme = fs::read_to_string(patterns.join("README.md")).expect("patterns/README.md");
    let fresh = tempfile::tempdir().unwrap();
    let picture = fresh.path().join("picture.svg");
    let mut drawn = 0;
    for entry in fs::read_dir(&patterns).unwrap() {
        let file = entry.unwrap().path();
        if file.extension().is_none_or(|ending| ending != "fold") {
            continue;
        }
        let name = format!("pictures/{}.svg", file.file_stem().unwrap().display());
        let run = Command::new(env!("CARGO_BIN_EXE_foldpath"))
            .args(["export", "--to", "svg", "-o"])
            .args([&picture, &file])
            .output()
            .expect("foldpath starts");
        assert!(run.status.success(), "{name}");
        let [fresh, kept] = [&picture, &patterns.join(&name)].map(fs::read);
        assert!(fresh.unwrap() == kept.expect(&name), "{name}");
        assert!(readme.contains(&name), "{name}");
        drawn += 1;
    }
    assert!(drawn > 0);
}

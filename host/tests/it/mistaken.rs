//! Tests what errors tell of files in formats that are not read.

use std::path::Path;

use foldpath::read::fold::parse_motion;
use foldpath::read::{Mistaken, parse_pattern, parse_shape};

/// Names with the beginnings of their files, and a part of what is told.
const FILES: [(&str, &[u8], &str); 20] = [
    (
        "photo.jpg",
        b"\xff\xd8\xff\xe0\0\x10JFIF",
        "picture of pixels",
    ),
    ("photo.svg", b"\x89PNG\r\n\x1a\n", "picture of pixels"),
    ("photo", b"RIFF\x10\0\0\0WEBPVP8 ", "picture of pixels"),
    ("photo.cp", b"\0\0\0\x18ftypheic", "picture of pixels"),
    ("scan.bmp", b"BM", "picture of pixels"),
    ("sheet.dxf", b"%PDF-1.7\n1 0 obj\n", "PDF, AI and EPS"),
    ("sheet.ai", b"", "PDF, AI and EPS"),
    ("sheet.obj", b"ISO-10303-21;\nHEADER;\n", "CAD files"),
    ("sheet.dwg", b"AC1032\0\0", "CAD files"),
    ("sheet.stl", b"PK\x03\x04", "archive"),
    ("sheet.3mf", b"PK\x03\x04", "such meshes"),
    ("sheet.fold", b"\x1f\x8b\x08", "archive"),
    ("sheet.glb", b"glTF\x02\0\0\0", "such meshes"),
    ("sheet.ply", b"ply\nformat ascii 1.0\n", "such meshes"),
    ("sheet.ori", b"{}", "Oriedita"),
    ("sheet.txt", b"<svg/>", "end in .svg"),
    ("sheet.txt", b"2 0 0 1 0\n", "end in .cp"),
    ("sheet.txt", b"  0\nSECTION\n", "end in .dxf"),
    ("sheet.txt", b"# a shape\nv 0 0 0\n", "with a name in .obj"),
    ("sheet.txt", b"solid shape\n", "with a name in .stl"),
];

#[test]
fn files_of_other_formats_are_recognised_whatever_their_name() {
    for (name, bytes, told) in FILES {
        let path = Path::new(name);
        let errors = [
            parse_pattern(path, bytes).unwrap_err(),
            parse_motion(path, bytes).unwrap_err(),
        ];
        for error in errors {
            let mistaken = error.mistaken(bytes).map(|it| it.to_string());
            assert!(
                mistaken.as_ref().is_some_and(|it| it.contains(told)),
                "{error}: {mistaken:?}"
            );
        }
    }
    let bytes = b"FPTJ\x01";
    let error = parse_pattern(Path::new("path.traj"), bytes).unwrap_err();
    assert_eq!(error.mistaken(bytes), Some(Mistaken::Trajectory));
}

/// A file that is what its name says has another defect.
#[test]
fn a_defect_of_a_file_is_no_other_format() {
    for (name, text) in [
        ("sheet.fold", "{"),
        ("sheet.fold", "{\"vertices_coords\": 3}"),
        ("sheet.svg", "<svg"),
        ("sheet.cp", "2 0 0\n"),
        ("sheet.dxf", "0\nSECTION\n"),
    ] {
        let error = parse_pattern(Path::new(name), text.as_bytes()).unwrap_err();
        assert_eq!(error.mistaken(text.as_bytes()), None, "{error}");
    }
    for (name, text) in [("shape.obj", "v 0 0 0\n"), ("shape.stl", "solid a\n")] {
        let shape = parse_shape(Path::new(name), text.as_bytes(), None, None);
        let error = shape.err().unwrap();
        assert_eq!(error.mistaken(text.as_bytes()), None, "{error}");
    }
}

//! Finds the keys of a file that neither FOLD nor this program knows.

use std::collections::BTreeSet;

use super::document::Document;

/// Largest number of unknown keys that a note names.
const MAX_NAMED_KEYS: usize = 8;
/// Largest number of characters of a key that a note shows.
const MAX_SHOWN_CHARS: usize = 40;

/// The known keys, sorted by their bytes: those of the FOLD specification 1.2, two with their names in 1.0, and the
/// keys of this program, which `FORMAT.md` describes.
const KNOWN: [&str; 57] = [
    "edgeOrders",
    "edges_assignment",
    "edges_faces",
    "edges_foldAngle",
    "edges_foldAngles",
    "edges_length",
    "edges_lengths",
    "edges_vertices",
    "faceOrders",
    "faces_edges",
    "faces_faces",
    "faces_vertices",
    "file_author",
    "file_classes",
    "file_creator",
    "file_description",
    "file_frames",
    "file_spec",
    "file_title",
    "foldpath:bend",
    "foldpath:bound",
    "foldpath:clearance",
    "foldpath:closure",
    "foldpath:cutsCorners",
    "foldpath:deformation",
    "foldpath:edges_foldAngleRate",
    "foldpath:edges_group",
    "foldpath:edges_sign",
    "foldpath:edges_weight",
    "foldpath:edges_weightRate",
    "foldpath:gap",
    "foldpath:hingePlane",
    "foldpath:interpolation",
    "foldpath:margin",
    "foldpath:maxAcceleration",
    "foldpath:maxSpeed",
    "foldpath:outcome",
    "foldpath:panelGap",
    "foldpath:panels",
    "foldpath:phases",
    "foldpath:precision",
    "foldpath:reached",
    "foldpath:seed",
    "foldpath:thickness",
    "foldpath:time",
    "frame_attributes",
    "frame_author",
    "frame_classes",
    "frame_description",
    "frame_inherit",
    "frame_parent",
    "frame_title",
    "frame_unit",
    "vertices_coords",
    "vertices_edges",
    "vertices_faces",
    "vertices_vertices",
];

/// Returns a note that names the unknown keys of a document, or `None` if all keys are known. Cost: linear in the
/// frames and their keys.
pub(super) fn not_known(document: &Document) -> Option<String> {
    let keys = document
        .keys()
        .filter(|key| KNOWN.binary_search(key).is_err());
    let keys: BTreeSet<&str> = keys.collect();
    let named = keys.iter().take(MAX_NAMED_KEYS).map(|key| {
        let shown: String = key.chars().take(MAX_SHOWN_CHARS).collect();
        format!("{shown:?}")
    });
    let named: Vec<String> = named.collect();
    let more = match keys.len() - named.len() {
        0 => String::new(),
        more => format!(" and {more} more"),
    };
    (!named.is_empty())
        .then(|| format!("keys not known, and left alone: {}{more}", named.join(", ")))
}

#[cfg(test)]
mod tests {
    use super::KNOWN;

    #[test]
    fn known_keys_are_in_order() {
        assert!(KNOWN.is_sorted());
    }
}

//! The keys that FOLD and this program know, and those of a file that neither does.

use std::collections::BTreeSet;

use super::document::Document;

/// Keys that are named.
const NAMED: usize = 8;
/// Characters of a key that are shown.
const SHOWN: usize = 40;

/// Those of the specification at version 1.2, two by their names in 1.0, and our own, which `FORMAT.md` describes;
/// in the order of their bytes.
const KNOWN: [&str; 46] = [
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
    "foldpath:clearance",
    "foldpath:closure",
    "foldpath:deformation",
    "foldpath:edges_foldAngleRate",
    "foldpath:edges_group",
    "foldpath:edges_sign",
    "foldpath:edges_weight",
    "foldpath:edges_weightRate",
    "foldpath:gap",
    "foldpath:interpolation",
    "foldpath:maxAcceleration",
    "foldpath:maxSpeed",
    "foldpath:phases",
    "foldpath:seed",
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

/// That a document has other keys, if it has. Cost: linear in its frames and their keys.
pub(super) fn not_known(document: &Document) -> Option<String> {
    let keys = document
        .keys()
        .filter(|key| KNOWN.binary_search(key).is_err());
    let keys: BTreeSet<&str> = keys.collect();
    let named = keys.iter().take(NAMED).map(|key| {
        let shown: String = key.chars().take(SHOWN).collect();
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

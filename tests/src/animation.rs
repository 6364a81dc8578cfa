//! A path file as plain lists of numbers.

use nalgebra::Vector3;
use serde_json::{Value, from_value};

use crate::{Motion, Sheet};

/// The content of a path file.
pub struct Animation {
    /// The key frame: the flat sheet.
    pub sheet: Sheet,
    /// The knots from start to goal.
    pub frames: Vec<Frame>,
    /// The motion between them.
    pub motion: Motion,
}

/// One knot.
pub struct Frame {
    /// Seconds since the start.
    pub time: f64,
    /// Fold angle of every edge, radians.
    pub angles: Vec<f64>,
    /// Folded position of every vertex.
    pub vertices: Vec<Vector3<f64>>,
}

impl Animation {
    /// Reads a path from the text of a FOLD file.
    ///
    /// # Errors
    /// If the text is not JSON, or if a key is missing or of another kind.
    pub fn parse(text: &str) -> serde_json::Result<Self> {
        let file: Value = serde_json::from_str(text)?;
        let frames: Vec<Value> = from_value(file["file_frames"].clone())?;
        Ok(Self {
            sheet: Sheet::of(&file)?,
            motion: Motion::of(&file)?,
            frames: frames.iter().map(Frame::of).collect::<Result<_, _>>()?,
        })
    }
}

impl Frame {
    fn of(frame: &Value) -> serde_json::Result<Self> {
        let degrees: Vec<f64> = from_value(frame["edges_foldAngle"].clone())?;
        let vertices: Vec<[f64; 3]> = from_value(frame["vertices_coords"].clone())?;
        Ok(Self {
            time: from_value(frame["foldpath:time"].clone())?,
            angles: degrees.into_iter().map(f64::to_radians).collect(),
            vertices: vertices.into_iter().map(Vector3::from).collect(),
        })
    }
}

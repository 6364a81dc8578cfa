//! The motion between the knots of a path file, by the formulas of `host/FORMAT.md`.

use serde_json::{Value, from_value};

/// A path that can be evaluated between its knots.
#[derive(Clone, Debug)]
pub struct Motion {
    kind: String,
    knots: Vec<Knot>,
}

/// One knot: numbers of every edge, radians.
#[derive(Clone, Debug)]
struct Knot {
    time: f64,
    angles: Vec<f64>,
    rates: Vec<f64>,
    weights: Vec<[f64; 2]>,
}

impl Motion {
    /// Reads the motion of a path file.
    ///
    /// # Errors
    /// If a key is missing or of another kind.
    pub fn of(file: &Value) -> serde_json::Result<Self> {
        let kind: String = from_value(file["foldpath:interpolation"].clone())?;
        let frames: Vec<Value> = from_value(file["file_frames"].clone())?;
        let knots = frames.iter().map(|frame| Knot::of(frame, &kind));
        Ok(Self {
            knots: knots.collect::<Result<_, _>>()?,
            kind,
        })
    }

    /// Returns the number of segments.
    #[must_use]
    pub fn segments(&self) -> usize {
        self.knots.len().saturating_sub(1)
    }

    /// Returns the fold angle of every edge in a segment, radians; `s` is the fraction of the segment, from 0 to 1.
    ///
    /// # Panics
    /// If the file names an unknown kind of interpolation.
    #[must_use]
    pub fn angles(&self, segment: usize, s: f64) -> Vec<f64> {
        let edges = 0..self.knots[segment].angles.len();
        edges.map(|edge| self.angle(segment, s, edge)).collect()
    }

    /// Returns the fold angle of one edge in a segment, radians; `s` is the fraction of the segment, from 0 to 1.
    ///
    /// # Panics
    /// If the file names an unknown kind of interpolation.
    #[must_use]
    pub fn angle(&self, segment: usize, s: f64, edge: usize) -> f64 {
        let knots = [&self.knots[segment], &self.knots[segment + 1]];
        let span = knots[1].time - knots[0].time;
        let cubic = |[p, q]: [f64; 2], [m, n]: [f64; 2]| {
            let (square, cube) = (s * s, s * s * s);
            (2.0 * cube - 3.0 * square + 1.0) * p
                + (cube - 2.0 * square + s) * span * m
                + (3.0 * square - 2.0 * cube) * q
                + (cube - square) * span * n
        };
        let angles = knots.map(|knot| knot.angles[edge]);
        let rates = knots.map(|knot| knot.rates[edge]);
        match self.kind.as_str() {
            "linear" => angles[0] + s * (angles[1] - angles[0]),
            "hermite" => cubic(angles, rates),
            "half-angle" => {
                let tangents = angles.map(|angle| (angle / 2.0).tan());
                let grow = [0, 1].map(|k| rates[k] / 2.0 * (1.0 + tangents[k].powi(2)));
                2.0 * cubic(tangents, grow).atan()
            }
            "homogeneous" => {
                let pair = [0, 1].map(|k| {
                    let [weight, grow] = knots[k].weights[edge];
                    let ((sin, cos), turn) = ((angles[k] / 2.0).sin_cos(), rates[k] / 2.0);
                    [
                        [weight * cos, grow * cos - weight * turn * sin],
                        [weight * sin, grow * sin + weight * turn * cos],
                    ]
                });
                let [c, n] = [0, 1].map(|part| {
                    let ends = pair.map(|knot| knot[part]);
                    cubic(ends.map(|end| end[0]), ends.map(|end| end[1]))
                });
                2.0 * n.atan2(c)
            }
            other => panic!("interpolation {other}"),
        }
    }
}

impl Knot {
    fn of(frame: &Value, kind: &str) -> serde_json::Result<Self> {
        let list = |key: &str| from_value::<Vec<Option<f64>>>(frame[key].clone());
        let radians = |key: &str| -> serde_json::Result<Vec<f64>> {
            let degrees = list(key)?.into_iter();
            Ok(degrees
                .map(|x| x.unwrap_or(f64::NAN).to_radians())
                .collect())
        };
        let angles = radians("edges_foldAngle")?;
        let weights = if kind == "homogeneous" {
            let [weights, grow] = ["foldpath:edges_weight", "foldpath:edges_weightRate"].map(list);
            let pairs = weights?.into_iter().zip(grow?);
            let pairs = pairs.map(|(weight, grow)| [weight.unwrap_or(1.0), grow.unwrap_or(0.0)]);
            pairs.collect()
        } else {
            Vec::new()
        };
        Ok(Self {
            time: from_value(frame["foldpath:time"].clone())?,
            rates: if kind == "linear" {
                vec![0.0; angles.len()]
            } else {
                radians("foldpath:edges_foldAngleRate")?
            },
            angles,
            weights,
        })
    }
}

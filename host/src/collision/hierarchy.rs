//! Hierarchy of clusters for the bounding spheres of a sweep: clusters of adjacent pieces, and clusters of clusters.
//!
//! Made once from the flat sheet; only the spheres round the clusters change along a motion.

use nalgebra::{Vector2, Vector3};

use super::pieces::Pieces;
use super::tolerances::MAX_CIRCLE_CORNERS;
use crate::pattern::FaceId;

/// A sphere in space.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sphere {
    pub(super) center: Vector3<f64>,
    pub(super) radius: f64,
}

impl Sphere {
    /// Returns the smallest sphere that contains both.
    pub(super) fn round(self, other: Self) -> Self {
        let between = other.center - self.center;
        let distance = between.norm();
        if distance + other.radius <= self.radius {
            return self;
        }
        if distance + self.radius <= other.radius {
            return other;
        }
        let radius = (distance + self.radius + other.radius) / 2.0;
        Self {
            center: self.center + between * ((radius - self.radius) / distance),
            radius,
        }
    }

    /// Returns the distance between two spheres, below 0 if they overlap.
    pub(super) fn distance(&self, other: &Self) -> f64 {
        (other.center - self.center).norm() - self.radius - other.radius
    }
}

/// A piece, or a cluster of two other nodes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Node {
    /// The two child nodes; `None` for a piece, which has the number of its node.
    pub(super) children: Option<[u32; 2]>,
    /// Number of pieces.
    pub(super) pieces: u32,
    /// A face in the middle, taken from one of the children.
    pub(super) face: FaceId,
}

/// The clusters of a sheet; pieces come first, children before parents.
#[derive(Clone, Debug, Default)]
pub(super) struct Hierarchy {
    pub(super) nodes: Vec<Node>,
    /// The node of all pieces; `None` without clusters.
    pub(super) root: Option<u32>,
    /// For each piece a circle round it in the flat sheet: centre and radius.
    pub(super) circles: Vec<(Vector2<f64>, f64)>,
}

impl Hierarchy {
    /// Creates a hierarchy without clusters: every piece on its own.
    pub(super) fn leaves(pieces: &Pieces) -> Self {
        let mut hierarchy = Self::default();
        hierarchy.extend(pieces);
        hierarchy
    }

    /// Adds the pieces made since the last call, each on its own.
    pub(super) fn extend(&mut self, pieces: &Pieces) {
        for piece in &pieces.list[self.nodes.len()..] {
            self.nodes.push(Node {
                children: None,
                pieces: 1,
                face: piece.face,
            });
            let (center, radius) = circle(&pieces.flat[piece.corners()]);
            self.circles.push((center, radius + pieces.height()));
        }
    }

    /// Builds the hierarchy bottom-up, level by level; the smallest clusters are joined first. Cost: O(pieces
    /// log pieces), if none has very many neighbours.
    pub(super) fn new(pieces: &Pieces) -> Self {
        let hierarchy = Self::leaves(pieces);
        let faces = pieces.list.last().map_or(0, |piece| piece.face.index() + 1);
        let mut face_centers = vec![Vector2::zeros(); faces];
        for (piece, (center, _)) in pieces.list.iter().zip(&hierarchy.circles) {
            face_centers[piece.face.index()] = *center;
        }
        let mut builder = Builder {
            pieces,
            members: (0..).take(pieces.list.len()).map(|k| vec![k]).collect(),
            cluster: (0..).take(pieces.list.len()).collect(),
            hierarchy,
            face_centers,
        };
        builder.join();
        builder.hierarchy
    }
}

struct Builder<'a> {
    pieces: &'a Pieces,
    hierarchy: Hierarchy,
    /// For each node its pieces; empty once the node has a parent.
    members: Vec<Vec<u32>>,
    /// For each piece the node that contains it and has no parent yet.
    cluster: Vec<u32>,
    /// For each face the centre of one of its pieces.
    face_centers: Vec<Vector2<f64>>,
}

impl Builder<'_> {
    fn join(&mut self) {
        let mut open: Vec<u32> = (0..).take(self.members.len()).collect();
        // The node of each sheet.
        let mut sheets = Vec::new();
        while !open.is_empty() {
            let (mut next, mut fresh) = (Vec::new(), self.hierarchy.nodes.len());
            open.sort_by_key(|&node| self.hierarchy.nodes[node as usize].pieces);
            for node in open {
                // The node may have been joined already.
                if self.members[node as usize].is_empty() {
                    continue;
                }
                match self.partner(node, fresh) {
                    Some(partner) => self.merge(node, partner),
                    None => sheets.push(node),
                }
            }
            while fresh < self.members.len() {
                if !self.members[fresh].is_empty() {
                    next.push(FaceId::new(fresh).0);
                }
                fresh += 1;
            }
            open = next;
        }
        self.hierarchy.root = sheets.into_iter().reduce(|all, sheet| {
            self.merge(all, sheet);
            FaceId::new(self.members.len() - 1).0
        });
    }

    /// Returns the neighbour of a cluster with the nearest centre; one not yet joined on this level, if there is one.
    fn partner(&self, node: u32, fresh: usize) -> Option<u32> {
        let members = &self.members[node as usize];
        let joints = members.iter().flat_map(|&p| self.pieces.joints(p));
        let others = joints.map(|joint| self.cluster[joint.piece as usize]);
        let size = |other: u32| {
            let both = [node, other].map(|n| self.center(n));
            (other as usize >= fresh, (both[0] - both[1]).norm())
        };
        let others = others.filter(|&other| other != node);
        others.min_by(|&a, &b| {
            let (a, b) = (size(a), size(b));
            a.0.cmp(&b.0).then(a.1.total_cmp(&b.1))
        })
    }

    #[allow(clippy::cast_precision_loss, reason = "a mean")]
    fn center(&self, node: u32) -> Vector2<f64> {
        let members = &self.members[node as usize];
        let centers = members
            .iter()
            .map(|&p| self.hierarchy.circles[p as usize].0);
        centers.sum::<Vector2<f64>>() / members.len() as f64
    }

    fn merge(&mut self, a: u32, b: u32) {
        let node = FaceId::new(self.members.len()).0;
        let mut members = core::mem::take(&mut self.members[a as usize]);
        members.append(&mut self.members[b as usize]);
        for &piece in &members {
            self.cluster[piece as usize] = node;
        }
        let count = members.len();
        self.members.push(members);
        let center = self.center(node);
        let [face, other] = [a, b].map(|child| self.hierarchy.nodes[child as usize].face);
        let away = |face: FaceId| (self.face_centers[face.index()] - center).norm();
        self.hierarchy.nodes.push(Node {
            children: Some([a, b]),
            pieces: FaceId::new(count).0,
            face: if away(other) < away(face) {
                other
            } else {
                face
            },
        });
    }
}

/// Returns centre and radius of a circle round some points: the smallest of those round the middle of two
/// points or the mean of all.
pub(super) fn circle(points: &[Vector2<f64>]) -> (Vector2<f64>, f64) {
    let count = Some(points.len()).filter(|&count| count <= MAX_CIRCLE_CORNERS);
    let few = &points[..count.unwrap_or_default()];
    let pairs = few.iter().enumerate().flat_map(|(k, a)| {
        let before = few[..k].iter();
        before.map(move |b| (a + b) / 2.0)
    });
    #[allow(clippy::cast_precision_loss, reason = "a mean")]
    let mean = points.iter().sum::<Vector2<f64>>() / points.len() as f64;
    let reach = |center: Vector2<f64>| {
        let away = points.iter().map(|p| (p - center).norm_squared());
        away.fold(0.0, f64::max)
    };
    let candidates = pairs.chain([mean]).map(|center| (center, reach(center)));
    let least = candidates.min_by(|a, b| a.1.total_cmp(&b.1));
    least.map_or((mean, 0.0), |(center, squared)| (center, squared.sqrt()))
}

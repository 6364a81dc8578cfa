//! Does a goal that lies flat have an order of its layers? Compared with all orders of strips and maps, one by one.

use core::f64::consts::PI;

use foldpath::collision::faces_without_order;
use foldpath::pattern::{CreasePattern, Drawing, DrawnEdge, FaceId, Letter};
use foldpath_tests::Random;
use nalgebra::Vector2;

/// Depth of contact, median edges.
const CONTACT: f64 = 1e-6;

/// Connector of two layers: at this place along an axis, and the layers from lower to higher number.
#[derive(Clone, Copy)]
struct Fold {
    layers: [usize; 2],
    /// Axis across the crease: 0 or 1.
    axis: usize,
    at: i32,
    /// The layers extend from the crease to larger coordinates.
    opens_up: bool,
    is_valley: bool,
}

/// Layers, each a rectangle with its lower and its upper corner and the side that is up, and what joins them.
struct Layers {
    rectangles: Vec<[[i32; 2]; 2]>,
    is_up: Vec<bool>,
    folds: Vec<Fold>,
}

impl Layers {
    /// Returns `true` if no layer passes through another or a crease, with these heights of the layers.
    fn are_free(&self, heights: &[usize]) -> bool {
        let between = |[a, b]: [usize; 2], c: usize| {
            let [low, high] = [heights[a].min(heights[b]), heights[a].max(heights[b])];
            low < heights[c] && heights[c] < high
        };
        self.folds.iter().enumerate().all(|(k, fold)| {
            let [a, b] = fold.layers;
            let letter = (heights[b] > heights[a]) == (fold.is_valley == self.is_up[a]);
            let passes = (0..heights.len()).any(|c| {
                let [low, high] = self.rectangles[c];
                let covers = low[fold.axis] < fold.at && fold.at < high[fold.axis];
                covers && between(fold.layers, c)
            });
            let beside = |other: &Fold| {
                (other.axis, other.at, other.opens_up) == (fold.axis, fold.at, fold.opens_up)
            };
            let others = self.folds[k + 1..].iter().filter(|other| beside(other));
            let are_linked = |other: &Fold| {
                let inside = other.layers.map(|layer| between(fold.layers, layer));
                inside[0] != inside[1]
            };
            letter && !passes && !others.into_iter().any(are_linked)
        })
    }

    /// Returns how many orders are free.
    fn count(&self) -> usize {
        let mut heights: Vec<usize> = (0..self.rectangles.len()).collect();
        let mut count = 0;
        permuted(&mut heights, 0, &mut |heights| {
            count += usize::from(self.are_free(heights));
        });
        count
    }
}

fn permuted(list: &mut [usize], from: usize, act: &mut impl FnMut(&[usize])) {
    if from == list.len() {
        act(list);
    }
    for k in from..list.len() {
        list.swap(from, k);
        permuted(list, from + 1, act);
        list.swap(from, k);
    }
}

/// Draws a grid of cells with these widths and heights. `fold` gives the fold angle in half turns of each crease: that to
/// the right of a cell, or that above it.
fn grid(
    sizes: [&[i32]; 2],
    mut fold: impl FnMut([usize; 2], usize) -> i32,
) -> (CreasePattern, Vec<f64>) {
    let [columns, rows] = sizes.map(<[i32]>::len);
    let places = sizes.map(|sizes| {
        let mut places = vec![0];
        places.extend(sizes.iter().scan(0, |sum, size| {
            *sum += size;
            Some(*sum)
        }));
        places
    });
    let vertex = |x: usize, y: usize| y * (columns + 1) + x;
    let mut drawing = Drawing::default();
    for y in &places[1] {
        let row = places[0]
            .iter()
            .map(|&x| Vector2::new(f64::from(x), f64::from(*y)));
        drawing.vertices.extend(row);
    }
    let mut edge = |ends, turns: Option<i32>| {
        drawing.edges.push(match turns {
            None => DrawnEdge::boundary(ends),
            Some(turns) => DrawnEdge {
                ends,
                letter: match turns {
                    1 => Letter::Valley,
                    -1 => Letter::Mountain,
                    _ => Letter::Flat,
                },
                goal: Some(PI * f64::from(turns)),
            },
        });
    };
    for y in 0..rows {
        for x in 0..=columns {
            let inner = (0 < x && x < columns).then(|| fold([x - 1, y], 0));
            edge([vertex(x, y), vertex(x, y + 1)], inner);
        }
    }
    for x in 0..columns {
        for y in 0..=rows {
            let inner = (0 < y && y < rows).then(|| fold([x, y - 1], 1));
            edge([vertex(x, y), vertex(x + 1, y)], inner);
        }
    }
    let pattern = CreasePattern::new(drawing).unwrap();
    let creases = pattern.creases().iter();
    let goal = creases.map(|&crease| pattern.edge(crease).goal.unwrap_or(0.0));
    let goal = goal.collect();
    (pattern, goal)
}

/// Returns the layers of a strip with these widths, and letters in half turns between them. Faces at a flat crease are one
/// layer.
fn strip(widths: &[i32], letters: &[i32]) -> Layers {
    let mut layers = Layers {
        rectangles: vec![[[0, 0], [widths[0], 1]]],
        is_up: vec![true],
        folds: Vec::new(),
    };
    let mut at = widths[0];
    for (width, letter) in widths[1..].iter().zip(letters) {
        let last = layers.rectangles.len() - 1;
        let is_up = layers.is_up[last];
        if *letter == 0 {
            let way = if is_up { *width } else { -width };
            at += way;
        } else {
            layers.folds.push(Fold {
                layers: [last, last + 1],
                axis: 0,
                at,
                opens_up: !is_up,
                is_valley: *letter > 0,
            });
            layers.rectangles.push([[at, 0], [at, 1]]);
            layers.is_up.push(!is_up);
            at += if is_up { -width } else { *width };
        }
        let [low, high] = layers.rectangles.last_mut().unwrap();
        low[0] = low[0].min(at);
        high[0] = high[0].max(at);
    }
    layers
}

/// A strip is refused if and only if none of all orders of its layers is free. Sides of many layers lie on one line.
#[test]
fn a_strip_has_an_order_if_one_of_all_is_free() {
    let mut tally = [0, 0];
    for seed in 0..2000 {
        let random = &mut Random::new(seed);
        let count = random.whole(3, 10);
        let widths: Vec<i32> = (0..count).map(|_| [1, 2, 3][random.below(3)]).collect();
        let flat = [0.15, 0.5][random.below(2)];
        let letters: Vec<i32> = (1..count)
            .map(|_| {
                if random.chance(flat) {
                    0
                } else {
                    [-1, 1][random.below(2)]
                }
            })
            .collect();
        let layers = strip(&widths, &letters);
        if layers.rectangles.len() > 7 {
            continue;
        }
        let (pattern, goal) = grid([&widths, &[1]], |[x, _], _| letters[x]);
        let refused = !faces_without_order(&pattern, &goal, CONTACT).is_empty();
        assert_eq!(
            refused,
            layers.count() == 0,
            "{seed}: {widths:?} {letters:?}"
        );
        tally[usize::from(refused)] += 1;
    }
    assert!(tally.iter().all(|&count| count > 50), "{tally:?}");
}

/// All letters of maps of 2 by 2 and 2 by 3 cells: those are refused for which no order is free. The number
/// of free orders is that of the ways to fold these maps: 8 and 60 (OEIS A001415).
#[test]
fn a_map_has_an_order_if_one_of_all_is_free() {
    for (columns, ways) in [(2, 8), (3, 60)] {
        let creases = (columns - 1) * 2 + columns;
        let (mut free, mut refusals) = (0, 0);
        for letters in 0..1_u32 << creases {
            let letter = |[x, y]: [usize; 2], axis: usize| {
                let number = if axis == 0 {
                    2 * x + y
                } else {
                    2 * (columns - 1) + x
                };
                if letters >> number & 1 == 1 { 1 } else { -1 }
            };
            let mut layers = Layers {
                rectangles: vec![[[0, 0], [1, 1]]; 2 * columns],
                is_up: (0..2 * columns).map(|k| (k / 2 + k % 2) % 2 == 0).collect(),
                folds: Vec::new(),
            };
            for x in 0..columns {
                for y in 0..2 {
                    let mut join = |to: [usize; 2], axis: usize, place: usize| {
                        layers.folds.push(Fold {
                            layers: [2 * x + y, 2 * to[0] + to[1]],
                            axis,
                            at: i32::from(place.is_multiple_of(2)),
                            opens_up: place % 2 == 1,
                            is_valley: letter([x, y], axis) > 0,
                        });
                    };
                    if x + 1 < columns {
                        join([x + 1, y], 0, x);
                    }
                    if y == 0 {
                        join([x, 1], 1, y);
                    }
                }
            }
            let (pattern, goal) = grid([&vec![1; columns], &[1, 1]], letter);
            let refused = !faces_without_order(&pattern, &goal, CONTACT).is_empty();
            let count = layers.count();
            assert_eq!(refused, count == 0, "{columns}: {letters:b}");
            free += count;
            refusals += usize::from(refused);
        }
        assert_eq!(free, ways);
        assert!(refusals > 0);
    }
}

/// One vertex with two mountains and two valleys in a large map: the four faces round it are named, and no other.
#[test]
fn no_more_faces_are_named_than_cannot_be_stacked() {
    let ones = [1; 12];
    let letter = |[x, y]: [usize; 2], axis: usize| {
        let (pleat, line) = if axis == 0 { (x, y) } else { (y, x) };
        let sign = if pleat % 2 == 0 { 1 } else { -1 };
        if axis == 0 && line % 2 == 1 {
            -sign
        } else {
            sign
        }
    };
    let (pattern, goal) = grid([&ones, &ones], letter);
    assert_eq!(faces_without_order(&pattern, &goal, CONTACT), []);
    let wrong = |cell: [usize; 2], axis| {
        let is_wrong = cell == [5, 11] && axis == 0;
        if is_wrong {
            -letter(cell, axis)
        } else {
            letter(cell, axis)
        }
    };
    let (pattern, goal) = grid([&ones, &ones], wrong);
    let faces = faces_without_order(&pattern, &goal, CONTACT);
    let around = |face: &FaceId| {
        let corners = pattern.faces()[face.index()].iter();
        let mut places = corners.map(|v| pattern.vertices()[v.index()]);
        places.any(|place| place == Vector2::new(6.0, 11.0))
    };
    assert_eq!(faces.len(), 4, "{faces:?}");
    assert!(faces.iter().all(around), "{faces:?}");
}

/// Faces that overlap by less than contact and rounding are not told apart.
#[test]
fn a_strip_is_not_refused_for_what_may_be_contact() {
    let longer = |by: f64| {
        let mut drawing = Drawing::default();
        let places = [0.0, 1.0 + 2.0 * by, 2.0 + 3.0 * by, 3.0 + 5.0 * by];
        for x in places {
            drawing
                .vertices
                .extend([0.0, 1.0].map(|y| Vector2::new(x, y)));
        }
        for k in 0..4 {
            let valley = DrawnEdge {
                ends: [2 * k, 2 * k + 1],
                letter: Letter::Valley,
                goal: Some(PI),
            };
            let border = DrawnEdge::boundary([2 * k, 2 * k + 1]);
            drawing.edges.push(if k % 3 == 0 { border } else { valley });
            if k < 3 {
                let ends = |y| [2 * k + y, 2 * k + 2 + y];
                drawing
                    .edges
                    .extend([0, 1].map(|y| DrawnEdge::boundary(ends(y))));
            }
        }
        CreasePattern::new(drawing).unwrap()
    };
    // The third layer reaches beyond the first crease by this length, the first layer beyond the second crease.
    let refused = |by| !faces_without_order(&longer(by), &[PI, PI], CONTACT).is_empty();
    assert_eq!(
        [1e-3, 1e-5, 1e-6, 1e-9].map(refused),
        [true, true, false, false]
    );
}

//! `.traj` files: are they read back as they were written, and is every other byte sequence refused?

use foldpath_core::trajectory::{TrajectoryError, TrajectoryView};
use foldpath_core::trajectory_file::{FileError, LagCost, TrajectoryFile, write};
use foldpath_core::wire::file::FileItems;
use foldpath_core::{
    GroupId, GroupLimits, Interpolation, Membership, Node, Scalar, Spoke, StarsView,
};
use foldpath_test_support::{Random, curve};
use rand_core::Rng;
use serde::Deserialize;

const LIMITS: [GroupLimits; 2] = [
    GroupLimits {
        lower: -f32::PI,
        upper: f32::PI,
        speed: 0.5,
        acceleration: f32::INFINITY,
    },
    GroupLimits {
        lower: 0.0,
        upper: 1.0,
        speed: 0.25,
        acceleration: 2.0,
    },
];
const SPANS: [f32; 3] = [0.0, 1.0, 1.5];
const ANGLES: [f32; 6] = [0.0, 0.0, -0.5, 0.25, -1.5, 1.0];
const RATES: [f32; 6] = [0.0, 0.125, -0.5, 0.25, 0.0, 0.0];
const WEIGHTS: [[f32; 2]; 6] = [
    [1.0, 0.0],
    [0.5, -1.0],
    [2.0, 0.25],
    [1.0, 1.0],
    [4.0, 0.0],
    [1.0, 0.5],
];

fn hinges() -> [Membership; 3] {
    [(1, false), (0, true), (1, true)].map(|(group, negative)| Membership {
        group: GroupId(group),
        negative,
    })
}

/// The spokes of two vertices: two of the first, one of the second.
fn spokes() -> [Spoke<f32>; 3] {
    [
        (1, true, [0.0, 1.0]),
        (0, false, [-0.6, 0.8]),
        (1, false, [1.0, 0.0]),
    ]
    .map(|(group, negative, direction)| Spoke {
        group: GroupId(group),
        negative,
        direction,
    })
}

const ENDS: [u32; 2] = [2, 3];
const CLOSURE: f32 = 0.0009765625;
const GAPS: [f32; 3] = [1.5, 0.5, 2.0];
const COST: LagCost<'_> = LagCost {
    most_lag: 0.125,
    gaps: &GAPS,
};
/// Bytes of this cost in a file, and of what stands behind it: the number of the path and the checksum.
const COST_BYTES: usize = 4 + 1 + 4 * 3;
const TAIL_BYTES: usize = 4 + 4;

fn view(kind: Interpolation) -> TrajectoryView<'static, f32> {
    let weights: &[[f32; 2]] = match kind {
        Interpolation::Homogeneous => &WEIGHTS,
        _ => &[],
    };
    TrajectoryView::new(kind, 2, &SPANS, &ANGLES, &RATES, weights).unwrap()
}

fn written(kind: Interpolation) -> Vec<u8> {
    let mut bytes = Vec::new();
    let spokes = spokes();
    let stars = StarsView::new(&spokes, &ENDS, 2).unwrap();
    let sink = |part: &[u8]| bytes.extend_from_slice(part);
    write(view(kind), &LIMITS, &hinges(), stars, CLOSURE, COST, sink).unwrap();
    bytes
}

const KINDS: [Interpolation; 4] = [
    Interpolation::Linear,
    Interpolation::Hermite,
    Interpolation::HalfAngle,
    Interpolation::Homogeneous,
];

/// Computes the CRC-32 bit by bit, from its definition.
fn crc(bytes: &[u8]) -> u32 {
    let shift = |crc: u32| (crc >> 1) ^ if crc & 1 == 1 { 0xedb8_8320 } else { 0 };
    let byte = |crc, byte: &u8| (0..8).fold(crc ^ u32::from(*byte), |crc, _| shift(crc));
    !bytes.iter().fold(!0, byte)
}

/// Returns the bytes with the right checksum at their end.
fn sealed(mut bytes: Vec<u8>) -> Vec<u8> {
    let body = bytes.len() - 4;
    let checksum = crc(&bytes[..body]).to_le_bytes();
    bytes[body..].copy_from_slice(&checksum);
    bytes
}

/// Asserts that the file has these spans and nodes.
fn assert_holds(file: &TrajectoryFile<'_>, view: TrajectoryView<'_, f32>) {
    for index in 0..view.len() {
        let knot = view.knot(index).unwrap();
        assert_eq!(file.span(index), Some(knot.span));
        for group in 0..view.groups() {
            let node = Node {
                angle: knot.angles[group],
                rate: knot.rates[group],
                weight: knot.weights.get(group).copied().unwrap_or([1.0, 0.0]),
            };
            assert_eq!(file.node(index, group), Some(node));
        }
    }
}

#[test]
fn what_is_written_is_read_back() {
    for kind in KINDS {
        let bytes = written(kind);
        let file = TrajectoryFile::read(&bytes).unwrap();
        assert_eq!((file.interpolation(), file.groups()), (kind, 2));
        assert_eq!((file.len(), file.hinges()), (3, 3));
        assert_eq!([0, 1].map(|group| file.limits(group)), LIMITS.map(Some));
        assert!(file.memberships().eq(hinges()));
        assert!(
            file.spokes()
                .eq(spokes().into_iter().zip([false, true, true]))
        );
        assert_eq!(file.closure().to_bits(), CLOSURE.to_bits());
        assert_eq!(file.most_lag().to_bits(), COST.most_lag.to_bits());
        assert!(file.gaps().eq(GAPS));
        assert_holds(&file, view(kind));
        for (segment, group) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
            let expected = view(kind).curve(segment, group);
            assert_eq!(curve(&file, segment, group), expected);
        }
        assert_eq!((file.span(3), file.limits(2)), (None, None));
        assert_eq!((file.node(0, 2), file.node(3, 0)), (None, None));
    }
}

/// A file of versions 2 and 3 has times instead of spans, and no number of the path; one of version 2 ends behind its knots, and
/// tells no cost.
#[test]
fn files_of_earlier_versions_are_read() {
    for (kind, version) in KINDS.into_iter().flat_map(|kind| [(kind, 2), (kind, 3)]) {
        let mut bytes = written(kind);
        let end = bytes.len() - TAIL_BYTES;
        let tail = if version == 2 { COST_BYTES } else { 0 };
        bytes.drain(end - tail..end + 4);
        bytes[4] = version;
        let record = 4 * (1 + 2 * kind.width());
        for (knot, time) in [10.0, 11.0, 12.5_f32].into_iter().enumerate() {
            bytes[PLACES[4] + knot * record..][..4].copy_from_slice(&time.to_le_bytes());
        }
        let bytes = sealed(bytes);
        let file = TrajectoryFile::read(&bytes).unwrap();
        assert_holds(&file, view(kind));
        let (most_lag, gaps) = if version == 2 {
            (f32::INFINITY, 0)
        } else {
            (COST.most_lag, 3)
        };
        assert_eq!(file.most_lag().to_bits(), most_lag.to_bits());
        assert_eq!(file.gaps().len(), gaps);
        let new = written(kind);
        let new = FileItems::new(TrajectoryFile::read(&new).unwrap()).unwrap();
        let old = FileItems::new(file).unwrap();
        assert_eq!(old.identity(), new.identity());
    }
}

/// The types that the protocol documents, decoded by postcard itself.
#[derive(Debug, PartialEq, Deserialize)]
#[serde(bound(deserialize = "[f32; N]: Deserialize<'de>"))]
struct Documented<const N: usize> {
    magic: [u8; 4],
    version: u8,
    interpolation: Interpolation,
    limits: Vec<[f32; 4]>,
    hinges: Vec<u32>,
    spokes: Vec<(u32, [f32; 2])>,
    closure: f32,
    knots: Vec<(f32, [[f32; N]; 2])>,
    most_lag: f32,
    gaps: Vec<f32>,
    path: [u8; 4],
    checksum: [u8; 4],
}

#[test]
fn the_file_is_the_postcard_of_its_documented_types() {
    let limits = LIMITS.map(|l| [l.lower, l.upper, l.speed, l.acceleration]);
    for kind in KINDS.into_iter().take(3) {
        let bytes = written(kind);
        let (file, rest) = postcard::take_from_bytes::<Documented<2>>(&bytes).unwrap();
        assert!(rest.is_empty());
        assert_eq!((&file.magic, file.version), (b"FPTJ", 4));
        assert_eq!(file.interpolation, kind);
        assert_eq!(
            (&file.limits[..], &file.hinges[..]),
            (&limits[..], &[2, 1, 3][..])
        );
        let spokes = [(5, [0.0, 1.0]), (2, [-0.6, 0.8]), (6, [1.0, 0.0])];
        assert_eq!((&file.spokes[..], file.closure), (&spokes[..], CLOSURE));
        let knots = [0, 1, 2].map(|k| {
            let pair = |i: usize| [ANGLES[i], RATES[i]];
            (SPANS[k], [pair(2 * k), pair(2 * k + 1)])
        });
        assert_eq!(file.knots, knots);
        assert_eq!((file.most_lag, &file.gaps[..]), (COST.most_lag, &GAPS[..]));
        let number = TrajectoryFile::read(&bytes).unwrap().path();
        assert_eq!(file.path, number.to_le_bytes());
        let expected = crc(&bytes[..bytes.len() - 4]).to_le_bytes();
        assert_eq!(file.checksum, expected);
    }
    let bytes = written(Interpolation::Homogeneous);
    let file: Documented<4> = postcard::from_bytes(&bytes).unwrap();
    let last = [4, 5].map(|i| [ANGLES[i], RATES[i], WEIGHTS[i][0], WEIGHTS[i][1]]);
    assert_eq!(file.knots.last(), Some(&(1.5, last)));
}

#[test]
fn every_flipped_byte_is_refused() {
    for kind in KINDS {
        let good = written(kind);
        for at in 0..good.len() {
            for flip in 1..=255 {
                let mut bytes = good.clone();
                bytes[at] ^= flip;
                assert!(TrajectoryFile::read(&bytes).is_err(), "{at} {flip}");
            }
        }
    }
}

#[test]
fn every_other_length_is_refused() {
    for kind in KINDS {
        let mut bytes = written(kind);
        for length in 0..bytes.len() {
            let error = TrajectoryFile::read(&bytes[..length]).unwrap_err();
            assert!(
                matches!(error, FileError::Truncated(at) if at <= length),
                "{error:?}"
            );
        }
        let whole = bytes.len();
        bytes.push(0);
        let error = TrajectoryFile::read(&bytes).unwrap_err();
        assert_eq!(error, FileError::Trailing(whole));
    }
}

/// Offsets, in bytes, of the limits, the hinges, the spokes, the closure and the knots in a file with 2 groups, 3
/// hinges and 3 spokes.
const PLACES: [usize; 5] = [7, 40, 44, 71, 76];

/// Changes a file, corrects its checksum and the number of its path, reads it and returns the result.
fn changed(kind: Interpolation, change: impl FnOnce(&mut [u8])) -> Result<(), FileError> {
    let mut bytes = written(kind);
    change(&mut bytes);
    let mut bytes = sealed(bytes);
    if let Err(FileError::Path(number)) = TrajectoryFile::read(&bytes) {
        let at = bytes.len() - TAIL_BYTES;
        bytes[at..][..4].copy_from_slice(&number.to_le_bytes());
    }
    TrajectoryFile::read(&sealed(bytes)).map(drop)
}

/// Replaces the number at byte `at`, corrects checksum and number of the path, reads the file and returns the result.
fn with_number(kind: Interpolation, at: usize, value: f32) -> Result<(), FileError> {
    changed(kind, |bytes| {
        bytes[at..][..4].copy_from_slice(&value.to_le_bytes());
    })
}

#[test]
fn each_refusal_says_what_and_where() {
    use TrajectoryError::{HalfTurn, NotFinite, Order, Weight};
    let hermite = Interpolation::Hermite;
    let byte = |at: usize, value| changed(hermite, |bytes| bytes[at] = value).unwrap_err();
    assert_eq!(byte(0, 0), FileError::Magic);
    assert_eq!(byte(4, 1), FileError::Version(1));
    assert_eq!(byte(5, 4), FileError::Interpolation(4));
    assert_eq!(byte(PLACES[1] + 1, 5), FileError::Hinge(1));
    assert_eq!(byte(PLACES[2] + 9, 8), FileError::Spoke(1));
    assert_eq!(byte(PLACES[2] + 18, 4), FileError::Spoke(2));
    let cut = byte(PLACES[2] - 1, 127);
    assert!(
        matches!(cut, FileError::Truncated(at) if at > PLACES[4]),
        "{cut}"
    );
    assert_eq!(byte(6, 20), FileError::Truncated(PLACES[0]));
    assert_eq!(byte(PLACES[4] - 1, 9), FileError::Truncated(PLACES[4]));
    let groups = changed(hermite, |bytes| {
        bytes[6..9].copy_from_slice(&[0x80, 0x80, 4])
    });
    assert_eq!(groups, Err(FileError::Groups));
    let number = changed(hermite, |bytes| bytes[PLACES[1]..][..5].fill(0xff));
    assert_eq!(number, Err(FileError::Number(PLACES[1])));
    let mut unsealed = written(hermite);
    unsealed[PLACES[4]] ^= 1;
    let checksum = TrajectoryFile::read(&unsealed).unwrap_err();
    assert_eq!(checksum, FileError::Checksum);

    let cost = written(hermite).len() - TAIL_BYTES - COST_BYTES;
    for (at, value, expected) in [
        (cost, 0.0, Err(FileError::MostLag)),
        (cost, f32::NAN, Err(FileError::MostLag)),
        (cost, f32::INFINITY, Ok(())),
        (cost + 5, -0.5, Err(FileError::Gap(0))),
        (cost + 13, f32::INFINITY, Err(FileError::Gap(2))),
        (cost + 13, 0.0, Ok(())),
    ] {
        assert_eq!(with_number(hermite, at, value), expected, "{at} {value}");
    }
    // The number of the path is that of its numbers.
    let path = TrajectoryFile::read(&written(hermite)).unwrap().path();
    let mut other = written(hermite);
    let at = other.len() - TAIL_BYTES;
    other[at] ^= 1;
    let other = TrajectoryFile::read(&sealed(other)).map(drop);
    assert_eq!(other, Err(FileError::Path(path)));
    // Two gaps for three hinges.
    let mut two = written(hermite);
    two[cost + 4] = 2;
    two.drain(cost + 5..cost + 9);
    let two = TrajectoryFile::read(&sealed(two)).map(drop);
    assert_eq!(two, Err(FileError::Gap(2)));

    let knot = |error| Err(FileError::Knot(error));
    let beyond = |knot, group| Err(FileError::Angle { knot, group });
    let (half_angle, homogeneous) = (Interpolation::HalfAngle, Interpolation::Homogeneous);
    // The third column is the index of the number within its part of the file (`part`, an index of `PLACES`).
    for (part, kind, place, value, expected) in [
        (0, hermite, 0, f32::NAN, Err(FileError::Limits(0))),
        (0, hermite, 1, f32::INFINITY, Err(FileError::Limits(0))),
        (0, hermite, 4, 1.5, Err(FileError::Limits(1))),
        (0, hermite, 6, 0.0, Err(FileError::Limits(1))),
        (0, hermite, 7, -1.0, Err(FileError::Limits(1))),
        (0, hermite, 7, f32::INFINITY, Ok(())),
        (3, hermite, 0, f32::NAN, Err(FileError::Closure)),
        (3, hermite, 0, -1e-6, Err(FileError::Closure)),
        (3, hermite, 0, 0.0, Ok(())),
        (4, hermite, 0, f32::NEG_INFINITY, knot(NotFinite(0))),
        (4, hermite, 5, 0.0, knot(Order(1))),
        (4, hermite, 5, -1.0, knot(Order(1))),
        (4, hermite, 0, 1.0, knot(Order(0))),
        (4, hermite, 10, f32::NAN, knot(NotFinite(2))),
        (4, hermite, 7, f32::INFINITY, knot(NotFinite(1))),
        (4, hermite, 8, 1.25, beyond(1, 1)),
        (4, hermite, 3, -0.25, beyond(0, 1)),
        (4, hermite, 1, f32::PI, Ok(())),
        (4, half_angle, 1, f32::PI, knot(HalfTurn(0))),
        (4, homogeneous, 1, f32::PI, Ok(())),
        (4, homogeneous, 3, 0.0, knot(Weight(0))),
        (4, homogeneous, 16, f32::NAN, knot(Weight(1))),
    ] {
        let found = with_number(kind, PLACES[part] + 4 * place, value);
        assert_eq!(found, expected, "{part} {kind:?} {place} {value}");
    }
}

#[test]
fn what_would_not_be_read_is_not_written() {
    let write = |limits: &[GroupLimits], hinges: &[Membership], angle| {
        let mut angles = ANGLES;
        angles[3] = angle;
        let view =
            TrajectoryView::new(Interpolation::Hermite, 2, &SPANS, &angles, &RATES, &[]).unwrap();
        written_bytes(|sink| {
            write(
                view,
                limits,
                hinges,
                stars(&[]),
                CLOSURE,
                LagCost::UNKNOWN,
                sink,
            )
        })
    };
    let stray = Membership {
        group: GroupId(2),
        negative: true,
    };
    let still = GroupLimits {
        speed: 0.0,
        ..LIMITS[0]
    };
    assert_eq!(write(&LIMITS, &hinges(), 0.25), Ok(()));
    assert_eq!(write(&LIMITS[..1], &[], 0.25), Err(FileError::Limits(1)));
    assert_eq!(
        write(&[LIMITS[1], still], &[], 0.25),
        Err(FileError::Limits(1))
    );
    assert_eq!(write(&LIMITS, &[stray], 0.25), Err(FileError::Hinge(0)));
    let beyond = FileError::Angle { knot: 1, group: 1 };
    assert_eq!(write(&LIMITS, &[], 1.25), Err(beyond));

    let write = |spokes: &[Spoke<f32>], closure| {
        let view = view(Interpolation::Hermite);
        written_bytes(|sink| {
            let (stars, cost) = (stars(spokes), LagCost::UNKNOWN);
            foldpath_core::trajectory_file::write(view, &LIMITS, &[], stars, closure, cost, sink)
        })
    };
    let mut spokes = spokes();
    assert_eq!(write(&spokes, 0.0), Ok(()));
    assert_eq!(write(&spokes, f32::INFINITY), Err(FileError::Closure));
    assert_eq!(write(&spokes, -1e-9), Err(FileError::Closure));
    spokes[1].group = GroupId(2);
    assert_eq!(write(&spokes, 0.0), Err(FileError::Spoke(1)));
}

/// Returns the stars of these spokes, three spokes or none, in three groups.
fn stars(spokes: &[Spoke<f32>]) -> StarsView<'_, f32> {
    let ends = if spokes.is_empty() { &[][..] } else { &ENDS };
    StarsView::new(spokes, ends, 3).unwrap()
}

/// Returns the result of writing. Asserts that nothing is written unless writing succeeds.
fn written_bytes(
    write: impl FnOnce(&mut dyn FnMut(&[u8])) -> Result<(), FileError>,
) -> Result<(), FileError> {
    let mut bytes = 0;
    let answer = write(&mut |part| bytes += part.len());
    assert_eq!(answer.is_ok(), bytes > 0);
    answer
}

#[test]
fn random_bytes_are_no_panic() {
    let mut rng = Random::new(77);
    let good = KINDS.map(written);
    for round in 0..100_000 {
        let mut bytes = good[round % 4].clone();
        // A few random changes anywhere, or noise behind the first bytes, with or without the right checksum.
        let from = [0, 4, 6][round % 3];
        if round % 5 < 3 {
            for _ in 0..=round % 4 {
                let at = rng.below(bytes.len());
                bytes[at] = rng.next_u32().to_le_bytes()[0];
            }
        } else {
            rng.fill_bytes(&mut bytes[from..]);
        }
        bytes.truncate(bytes.len() - [0, rng.below(90)][round % 2]);
        if round % 7 < 5 {
            bytes = sealed(bytes);
        }
        if let Ok(file) = TrajectoryFile::read(&bytes) {
            let node = |knot| (0..file.groups()).all(|group| file.node(knot, group).is_some());
            assert!((0..file.len()).all(node));
            assert_eq!(file.memberships().count(), file.hinges());
            assert!(
                file.spokes()
                    .all(|(spoke, _)| spoke.group.index() < file.groups())
            );
            let last = file.len().checked_sub(1);
            assert!(last.is_none_or(|last| file.span(last).is_some()));
        }
    }
}

/// Returns the bytes of the protocol's worked example: the hexadecimal numbers before each bar.
fn example() -> Vec<u8> {
    let text = include_str!("../../../firmware-sim/PROTOCOL.md");
    let (_, text) = text.split_once("```hex\n").unwrap();
    let (text, _) = text.split_once("```").unwrap();
    let lines = text.lines().map(|line| line.split('|').next().unwrap());
    let numbers = lines.flat_map(str::split_whitespace);
    numbers
        .map(|hex| u8::from_str_radix(hex, 16).unwrap())
        .collect()
}

#[test]
fn the_example_of_the_protocol_is_what_it_says() {
    let bytes = example();
    let file = TrajectoryFile::read(&bytes).unwrap();
    assert_eq!(file.interpolation(), Interpolation::Hermite);
    let (spans, rates) = ([0.0, 2.0, 1.5], [0.0; 6]);
    let angles = [0.0, 0.0, 1.0, 0.5, 0.5, 0.25];
    let view = TrajectoryView::new(file.interpolation(), 2, &spans, &angles, &rates, &[]).unwrap();
    assert_eq!((file.len(), file.groups()), (3, 2));
    assert_holds(&file, view);
    let limits = GroupLimits {
        lower: -f32::PI,
        upper: f32::PI,
        speed: 1.0,
        acceleration: f32::INFINITY,
    };
    let tame = GroupLimits {
        lower: 0.0,
        upper: 1.5,
        speed: 0.5,
        acceleration: 2.0,
    };
    assert_eq!(
        [0, 1].map(|group| file.limits(group)),
        [Some(limits), Some(tame)]
    );
    assert!(file.memberships().eq(hinges()));
    let mut again = Vec::new();
    let (spokes, ends): (Vec<_>, Vec<_>) = file.spokes().unzip();
    assert_eq!(ends, [false, true, true]);
    assert_eq!(spokes, self::spokes());
    let stars = StarsView::new(&spokes, &ENDS, 2).unwrap();
    assert_eq!(file.closure().to_bits(), CLOSURE.to_bits());
    let sink = |part: &[u8]| again.extend_from_slice(part);
    write(view, &[limits, tame], &hinges(), stars, CLOSURE, COST, sink).unwrap();
    assert_eq!(again, bytes);
    // Its number on the line is the one that the protocol gives.
    let number = FileItems::new(file).unwrap().identity();
    assert_eq!(number, file.path());
    let said = format!("example above has the number `{number:08x}`");
    let protocol = include_str!("../../../firmware-sim/PROTOCOL.md");
    assert!(protocol.contains(&said), "{said}");
}

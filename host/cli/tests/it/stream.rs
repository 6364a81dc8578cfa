//! Tests streaming to controllers: they execute what was planned, whatever the line does, and faults are reported.

use core::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use core::time::Duration;
use std::io::{self, ErrorKind, Read, Write};
use std::net::TcpListener;
use std::path::Path;
use std::process::Stdio;
use std::sync::Arc;
use std::thread::{self, JoinHandle, sleep};
use std::time::Instant;

use crate::common::folder;
use crate::session;
use foldpath::stream::{
    Ending, Faulty, Link, Options, Outcome, Plant, Sim, StreamPath, Summary, Telemetry, Wish,
};
use foldpath_controller::{Controller, Settings};
use foldpath_core::acceptance::{Setpoint, SheetView};
use foldpath_core::follower::{self, Fault, Follower, FollowerPosition, Reason, State};
use foldpath_core::trajectory::TrajectoryView;
use foldpath_core::trajectory_file::{LagCost, TrajectoryFile, write};
use foldpath_core::wire::cobs;
use foldpath_core::wire::frame;
use foldpath_core::wire::message::ToHost;
use foldpath_core::wire::protection::Unkeyed;
use foldpath_core::{
    GroupId, GroupLimits, Interpolation, Membership, Spoke, StarView, StarsView,
    local_foldability_matrix,
};
use foldpath_firmware_sim::faults::Faults;
use foldpath_firmware_sim::hinges::{Drive, Trouble};
use foldpath_test_support::{Folder, curve, spans};
use serde_json::Value;

/// Makes a folder with `path.traj` of a Miura fold of 24 x 24 faces.
fn miura(options: &str) -> Folder {
    let folder = folder();
    folder.done("generate miura --rows 24 --cols 24 -o miura.fold");
    folder.done(&format!("plan miura.fold -o path.fold {options}"));
    folder.done("export path.fold --to traj -o path.traj");
    folder
}

/// Makes a folder with `path.traj` of a small Miura fold that takes about two seconds.
fn small() -> Folder {
    let folder = folder();
    folder.done("generate miura --rows 3 --cols 3 -o miura.fold");
    folder.done("plan miura.fold --max-speed 90 -o path.fold");
    folder.done("export path.fold --to traj -o path.traj");
    folder
}

fn read(folder: &Folder) -> StreamPath {
    let bytes = std::fs::read(folder.path("path.traj")).unwrap();
    StreamPath::read(&bytes, Path::new("path.traj")).unwrap()
}

/// Returns the spokes of a file, and for each vertex the end of its spokes.
fn stars(file: &TrajectoryFile<'_>) -> (Vec<Spoke<f32>>, Vec<u32>) {
    let ends = (1..).zip(file.spokes()).filter(|(_, (_, last))| *last);
    let ends = ends.map(|(end, _)| end).collect();
    (file.spokes().map(|(spoke, _)| spoke).collect(), ends)
}

/// Runs a session of this number, which goes on or not. Returns its summary and its telemetry.
fn session(
    link: &mut impl Link,
    path: &StreamPath,
    (id, resume): (u32, bool),
    wish: &dyn Fn(&[Telemetry]) -> Wish,
) -> (Summary, Vec<Telemetry>) {
    let options = Options::default().with(|it| {
        it.resume = resume;
        it.id = id;
    });
    session::session(link, path, options, wish)
}

/// Returns the angles that the follower commands at each millisecond from the start on, if it has all setpoints.
fn own_run(bytes: &[u8]) -> Vec<[f32; 2]> {
    let file = TrajectoryFile::read(bytes).unwrap();
    let (spokes, ends) = stars(&file);
    let limits = [0, 1].map(|group| file.limits(group).unwrap());
    let sheet = SheetView {
        interpolation: file.interpolation(),
        limits: &limits,
        stars: StarsView::new(&spokes, &ends, 2).unwrap(),
        closure: file.closure(),
    };
    let mut follower = Follower::<f32, 2, 64>::new(follower::CheckedOptions::default());
    follower.load(&sheet, FollowerPosition::default()).unwrap();
    for knot in 0..file.len() {
        let nodes = [0, 1].map(|group| file.node(knot, group).unwrap());
        let setpoint = Setpoint {
            number: u32::try_from(knot).unwrap(),
            span: file.span(knot).unwrap(),
            last: knot + 1 == file.len(),
            nodes: nodes.into_iter().collect(),
        };
        follower.accept(&sheet, setpoint).unwrap();
    }
    follower.confirm().unwrap();
    follower.start().unwrap();
    let mut run = Vec::new();
    for tick in 1.. {
        follower.heard(1000 * tick);
        follower.tick(sheet.stars, 1000 * tick);
        run.push([follower.angles()[0], follower.angles()[1]]);
        if follower.state() == State::Done {
            break;
        }
    }
    run
}

/// Returns the angles at a place on the trajectory that the file holds.
fn at(bytes: &[u8], place: FollowerPosition<f32>) -> Vec<f32> {
    let file = TrajectoryFile::read(bytes).unwrap();
    let knot = place.knot as usize;
    let angle = |group| match file.span(knot + 1) {
        Some(span) if place.into > 0.0 => {
            curve(&file, knot, group).unwrap().angle(place.into / span)
        }
        _ => file.node(knot, group).unwrap().angle,
    };
    (0..file.groups()).map(angle).collect()
}

fn bits(angles: &[f32]) -> Vec<u32> {
    angles.iter().map(|angle| angle.to_bits()).collect()
}

/// Row of the log.
#[derive(Debug, PartialEq)]
struct Row {
    micros: u64,
    state: String,
    sequence: u32,
    angles: Vec<f32>,
}

fn rows(log: &str) -> Vec<Row> {
    let mut lines = log.lines();
    let head = lines.next().unwrap();
    assert!(
        head.starts_with("t_us,state,sequence,group_0,group_1,max_lag,lag_hinge,retransmitted,round_trip_us,hinge_0,hinge_1,"),
        "{log}"
    );
    let columns = head.split(',').count();
    let row = |line: &str| {
        let cells: Vec<&str> = line.split(',').collect();
        assert_eq!(cells.len(), columns, "{line}");
        let angles = cells[3..5].iter().filter(|cell| !cell.is_empty());
        Row {
            micros: cells[0].parse().unwrap(),
            state: cells[1].into(),
            sequence: cells[2].parse().unwrap(),
            angles: angles.map(|cell| cell.parse().unwrap()).collect(),
        }
    };
    lines.map(row).collect()
}

/// Asserts that the angles of rows equal those of the run at the same times, bit by bit.
#[track_caller]
fn runs_as(rows: &[Row], run: &[[f32; 2]]) {
    let moving = rows
        .iter()
        // Telemetry may come between the start and the first tick.
        .position(|row| row.state != "Idle" && row.state != "Ready" && row.angles[0] > 0.0);
    let rows = &rows[moving.expect("something moves")..];
    let first = (0..run.len()).find(|tick| bits(&run[*tick]) == bits(&rows[0].angles));
    let first = first.unwrap_or_else(|| panic!("{:?}", rows[0]));
    for row in rows {
        // A tick comes at each whole millisecond, and telemetry at any time behind it.
        let passed = usize::try_from(row.micros / 1000 - rows[0].micros / 1000).unwrap();
        let tick = (first + passed).min(run.len() - 1);
        assert_eq!(bits(&row.angles), bits(&run[tick]), "{row:?}");
    }
    assert_eq!(rows.last().unwrap().state, "Done");
}

#[test]
fn a_controller_executes_what_was_planned_bit_by_bit() {
    let folder = miura("");
    let answer = folder.done("stream path.traj --to sim --log log.csv --json");
    assert_eq!(answer.stderr, "");
    let json = answer.json();
    let keys: Vec<&String> = json.as_object().unwrap().keys().collect();
    let contract = [
        "bytes_sent",
        "duration",
        "lag_hinge",
        "max_closure",
        "max_lag",
        "outcome",
        "reason",
        "refused",
        "retransmitted",
        "round_trip",
        "setpoints",
    ];
    assert_eq!(keys, contract);
    assert_eq!(
        (&json["outcome"], &json["reason"]),
        (&"done".into(), &Value::Null)
    );
    // Ideal hinges have no sensors. The line takes a millisecond each way, and the time of the frames.
    assert_eq!(
        (&json["max_lag"], &json["lag_hinge"]),
        (&Value::Null, &Value::Null)
    );
    let trip = json["round_trip"].as_f64().unwrap();
    assert!((0.002..0.01).contains(&trip), "{trip}");
    let bytes = std::fs::read(folder.path("path.traj")).unwrap();
    let file = TrajectoryFile::read(&bytes).unwrap();
    assert_eq!(json["setpoints"], file.len());
    assert_eq!(
        (&json["retransmitted"], &json["refused"]),
        (&0.into(), &0.into())
    );

    let log = folder.read("log.csv");
    let rows = rows(&log);
    let run = own_run(&bytes);
    runs_as(&rows, &run);
    // Telemetry comes every 20 ms, so the first message of the motion comes within 20 ms.
    assert!(
        rows.windows(2)
            .all(|pair| pair[1].micros - pair[0].micros == 20_000)
    );
    let begin = rows.iter().find(|row| !row.angles.is_empty()).unwrap();
    assert!(
        run[..20]
            .iter()
            .any(|angles| bits(angles) == bits(&begin.angles))
    );
    let goal = file.node(file.len() - 1, 0).unwrap().angle;
    assert_eq!(run.last().unwrap()[0].to_bits(), goal.to_bits());
    assert!(
        rows.windows(2)
            .all(|pair| pair[0].sequence <= pair[1].sequence)
    );
    // Nothing is late: the duration is that of the path, of the start and end of its clock, and of opening the session.
    let path: f64 = (0..file.len())
        .map(|knot| f64::from(file.span(knot).unwrap()))
        .sum();
    let duration = json["duration"].as_f64().unwrap();
    assert!(
        (path..path + 0.5).contains(&duration),
        "{duration} of {path}"
    );

    // The closure residual is computed by the report's matrices, in numbers of 64 bits.
    let spokes: Vec<Spoke<f64>> = stars(&file).0.iter().map(widened).collect();
    let residual = |row: &Row| {
        let angles: Vec<f64> = row.angles.iter().copied().map(f64::from).collect();
        let star = StarView { spokes: &spokes };
        let matrix = local_foldability_matrix(star, [0.0; 2], &angles);
        let entry = |i: usize, j: usize| matrix[(i, j)] - if i == j { 1.0 } else { 0.0 };
        let places = (0..3).flat_map(|i| (0..3).map(move |j| (i, j)));
        let square: f64 = places.map(|(i, j)| entry(i, j).powi(2)).sum();
        (square / 2.0).sqrt()
    };
    let known = rows.iter().filter(|row| !row.angles.is_empty());
    let worst = known.map(residual).fold(0.0, f64::max);
    let told = json["max_closure"].as_f64().unwrap();
    assert!((told - worst).abs() < 1e-9, "{told:e} {worst:e}");
    assert!(told > 0.0 && told <= f64::from(file.closure()));

    let again = folder.done("stream path.traj --to sim --log again.csv --json");
    assert_eq!((again.json(), folder.read("again.csv")), (json, log));
}

fn widened(spoke: &Spoke<f32>) -> Spoke<f64> {
    let [x, y] = spoke.direction.map(f64::from);
    Spoke {
        group: spoke.group,
        negative: spoke.negative,
        direction: [x / x.hypot(y), y / x.hypot(y)],
    }
}

/// The bytes sent are compared with bare angles and rates of 1104 hinges at each knot, and with their angles fifty
/// times per second, which a controller needs that does not know the path between knots.
#[test]
fn two_groups_take_a_hundredth_of_the_bytes_of_their_hinges() {
    for (options, knots) in [
        ("", 5..8),
        ("--interpolation hermite --bound 0.00001", 19..100),
    ] {
        let folder = miura(options);
        let json = folder.done("stream path.traj --to sim --json").json();
        let number = |key: &str| json[key].as_u64().unwrap();
        let (setpoints, bytes) = (number("setpoints"), number("bytes_sent"));
        let duration = json["duration"].as_f64().unwrap();
        let bare = setpoints * 1104 * 8;
        println!("{setpoints} setpoints, {bytes} bytes, {bare} bare, {duration} s");
        assert!(knots.contains(&setpoints), "{setpoints}");
        assert!(
            bytes as f64 * 100.0 <= duration * 50.0 * 1104.0 * 4.0,
            "{bytes}"
        );
        let part = if setpoints < 19 { 50 } else { 150 };
        assert!(bytes * part <= bare, "{bytes} of {bare}");
    }
}

#[test]
fn faults_cost_time_alone() {
    let folder = miura("");
    let (path, bytes) = (
        read(&folder),
        std::fs::read(folder.path("path.traj")).unwrap(),
    );
    let goal = at(&bytes, FollowerPosition { knot: 5, into: 0.0 });
    let own = own_run(&bytes);
    let faults = Faults {
        drop: 0.1,
        flip: 0.1,
        double: 0.1,
        reorder: 0.1,
        ..Faults::default()
    };
    let (mut repeated, mut unheld) = (0, 0);
    for seed in 0..100 {
        let mut link = Faulty::new(Sim::new(), faults, seed);
        let (summary, heard) = session(&mut link, &path, (7, false), &|_| Wish::Run);
        assert_eq!(summary.outcome, Outcome::Done, "{seed}: {summary:?}");
        assert_eq!((summary.setpoints, summary.refused), (6, 0));
        repeated += u64::from(summary.retransmitted > 0);
        let known = || heard.iter().filter(|told| !told.angles.is_empty());
        for told in known() {
            assert_eq!(
                bits(&told.angles),
                bits(&at(&bytes, told.place)),
                "{seed}: {told:?}"
            );
        }
        assert_eq!(bits(&heard.last().unwrap().angles), bits(&goal), "{seed}");
        // If the motion was never held, the times agree too. Some telemetry is overtaken by later messages.
        if heard.iter().all(|told| told.state != State::Holding) {
            unheld += 1;
            let mut rows: Vec<Row> = known().map(row).collect();
            rows.sort_by_key(|row| row.micros);
            runs_as(&rows, &own);
        }
    }
    assert!(repeated >= 95 && unheld >= 80, "{repeated} {unheld}");
}

fn row(told: &Telemetry) -> Row {
    Row {
        micros: told.time,
        state: format!("{:?}", told.state),
        sequence: told.place.knot,
        angles: told.angles.clone(),
    }
}

#[test]
fn the_command_adds_faults_from_a_seed() {
    let folder = small();
    let stream = |seed: u32, log: &str| {
        let faults = format!("drop=0.1,flip=0.1,double=0.1,seed={seed}");
        let stream = format!("stream path.traj --to sim --json --log {log} --faults {faults}");
        (folder.done(&stream).json(), folder.read(log))
    };
    let [first, again, other] =
        [(7, "a.csv"), (7, "b.csv"), (8, "c.csv")].map(|(s, l)| stream(s, l));
    assert_eq!(first, again);
    assert_ne!(first.1, other.1);
    assert!(first.0["retransmitted"].as_u64().unwrap() > 0);
    assert_eq!(other.0["outcome"], "done");
    for (faults, message) in [
        ("drop", "expected KEY=VALUE, found drop"),
        ("drop=2", "drop: expected 0 to 1, found 2"),
        ("drop=NaN", "drop: expected 0 to 1, found NaN"),
        (
            "lose=0.1",
            "expected drop, flip, double, reorder or seed, found lose",
        ),
        ("seed=-1", "seed: expected a number, found -1"),
    ] {
        let stream = format!("stream path.traj --to sim --faults {faults}");
        let answer = folder.run(&stream).with_status(2);
        assert!(answer.stderr.contains(message), "{answer:?}");
    }
    let deaf = "stream path.traj --to sim --json --faults drop=1";
    let deaf = folder.run(deaf).with_status(1).json();
    assert_eq!(deaf["outcome"], "no_device");
    let reason = deaf["reason"].as_str().unwrap();
    assert!(reason.starts_with("no controller answers"), "{reason}");
}

/// Returns the answer of `stream` for a small sheet with these options for drives and script.
fn driven(folder: &Folder, options: &str) -> Value {
    let stream = "stream path.traj --to sim --sheet path.fold --json";
    folder.run(&format!("{stream} {options}")).json()
}

/// Drives that lag by a hundredth of a second are as far behind as they turn in that time.
#[test]
fn measured_angles_and_their_lag_are_told_and_logged() {
    let folder = small();
    let stream = "stream path.traj --to sim --drives lag=0.01 --log log.csv";
    let json = folder.done(&format!("{stream} --json")).json();
    let lag = json["max_lag"].as_f64().unwrap();
    assert!((0.5..1.0).contains(&lag), "{json}");
    let hinge = json["lag_hinge"].as_u64().unwrap();
    assert!(hinge < 12, "{json}");
    let log = folder.read("log.csv");
    let mut lines = log
        .lines()
        .map(|line| line.split(',').collect::<Vec<&str>>());
    let head = lines.next().unwrap();
    let column = |name: &str| head.iter().position(|cell| *cell == name).unwrap();
    let (mut worst, mut measured) = (0.0_f64, 0);
    let path = read(&folder);
    for row in lines {
        let number = |name: &str| row[column(name)].parse::<f64>().ok();
        let Some(largest) = number("max_lag") else {
            continue;
        };
        measured += 1;
        worst = worst.max(largest);
        // Twelve hinges are measured with each telemetry, and the lag is that of the row's own angles.
        let lags = path.hinges().iter().enumerate().map(|(hinge, member)| {
            let told = number(&format!("group_{}", member.group.index())).unwrap();
            let sign = if member.negative { -1.0 } else { 1.0 };
            (number(&format!("hinge_{hinge}")).unwrap() - sign * told).abs()
        });
        assert!((lags.fold(0.0, f64::max) - largest).abs() < 1e-6, "{row:?}");
    }
    assert!(measured > 50, "{measured}");
    assert!((worst.to_degrees() - lag).abs() < 1e-4, "{worst} {lag}");
    let text = folder.done(stream).stdout;
    assert!(
        text.contains("  lag          ") && text.contains("  round trip   "),
        "{text}"
    );
}

/// The true angles of the hinges determine the true shape of the sheet.
#[test]
fn drives_deform_the_sheet_by_what_they_are_off() {
    let folder = small();
    let number = |json: &Value, key: &str| json[key].as_f64().unwrap();
    // At the commanded angles the sheet closes to the precision of 32-bit numbers.
    let exact = driven(&folder, "");
    assert_eq!(exact["outcome"], "done");
    assert!(number(&exact, "max_deformation") < 1e-5, "{exact}");
    assert!(number(&exact, "max_gap") < 1e-5, "{exact}");
    // Hinges that all lag alike leave the sheet almost rigid; play and noise do not.
    let late = driven(&folder, "--drives lag=0.005");
    let loose = driven(&folder, "--drives play=0.01,noise=0.001,seed=3");
    for json in [&late, &loose] {
        assert_eq!(json["outcome"], "done");
    }
    let [whole, late, loose] = [exact, late, loose].map(|json| number(&json, "max_gap"));
    assert!(
        whole < late && late < loose && loose < 0.1,
        "{whole} {late} {loose}"
    );
}

#[test]
fn a_script_makes_a_hinge_stall_a_sensor_jump_and_the_supply_dip() {
    let folder = small();
    folder.write("stall.txt", "# the third\n\n0.8 stick 3 # for ever\n");
    let json = driven(&folder, "--script stall.txt");
    assert_eq!(json["outcome"], "faulted");
    let reason = json["reason"].as_str().unwrap();
    assert!(reason.contains("hinge 3 "), "{reason}");
    // The other hinges moved on until the controller saw the stall.
    assert!(json["max_gap"].as_f64().unwrap() > 1e-3);
    // Whichever hinge is stuck, the sheet opens: also at one off the tree along which it is folded.
    let gap = |hinge: usize| {
        folder.write("stuck.txt", &format!("0.8 stick {hinge}"));
        let json = driven(&folder, "--script stuck.txt");
        assert_eq!(json["outcome"], "faulted");
        json["max_gap"].as_f64().unwrap()
    };
    let gaps: Vec<f64> = (0..12).map(gap).collect();
    assert!(gaps.iter().all(|gap| *gap > 0.05), "{gaps:?}");

    folder.write("jump.txt", "0.8 jump 5 0.5");
    let json = driven(&folder, "--script jump.txt");
    assert_eq!(json["outcome"], "faulted");
    let reason = json["reason"].as_str().unwrap();
    assert!(reason.contains("hinge 5 "), "{reason}");

    folder.write("dip.txt", "1.6 supply 1\n0.8 supply 0.1\n");
    let [with, without] = ["--script dip.txt", ""].map(|script| {
        let json = driven(&folder, &format!("{script} --drives speed=2.5"));
        assert_eq!(json["outcome"], "done");
        json["duration"].as_f64().unwrap()
    });
    assert!(with > without + 0.3, "{with} {without}");

    folder.write("free.txt", "0.8 stick 3\n0.85 free 3");
    assert_eq!(driven(&folder, "--script free.txt")["outcome"], "done");
}

/// The setpoints of 94 groups come in four pieces, and their telemetry in two; the log has all groups.
#[test]
fn a_path_of_94_groups_is_streamed_whole() {
    const GROUPS: usize = 94;
    let folder = small();
    let times: Vec<f32> = (0..11_u8).map(|knot| f32::from(knot) * 0.2).collect();
    let angles: Vec<f32> = times
        .iter()
        .flat_map(|time| (0..GROUPS).map(move |group| time * if group < 40 { 0.5 } else { -0.25 }))
        .collect();
    let rates: Vec<f32> = (0..times.len())
        .flat_map(|_| (0..GROUPS).map(|group| if group < 40 { 0.5 } else { -0.25 }))
        .collect();
    let kind = Interpolation::Hermite;
    let spans = spans(11, 0.2);
    let view = TrajectoryView::new(kind, GROUPS, &spans, &angles, &rates, &[]).unwrap();
    let limits = [GroupLimits {
        lower: -1.0,
        upper: 1.5,
        speed: 1.0,
        acceleration: f32::INFINITY,
    }; GROUPS];
    let hinges: Vec<Membership> = (0..94_u32)
        .map(|group| Membership {
            group: GroupId(group),
            negative: false,
        })
        .collect();
    let stars = StarsView::new(&[], &[], GROUPS).unwrap();
    let mut bytes = Vec::new();
    write(
        view,
        &limits,
        &hinges,
        stars,
        0.0,
        LagCost::UNKNOWN,
        |more| bytes.extend_from_slice(more),
    )
    .unwrap();
    std::fs::write(folder.path("wide.traj"), &bytes).unwrap();
    let path = StreamPath::read(&bytes, Path::new("wide.traj")).unwrap();
    let (summary, heard) = session(&mut Sim::new(), &path, (1, false), &|_| Wish::Run);
    assert_eq!(summary.outcome, Outcome::Done, "{summary:?}");
    assert_eq!((summary.setpoints, summary.retransmitted), (11, 0));
    let known: Vec<_> = heard
        .iter()
        .filter(|told| !told.angles.is_empty())
        .collect();
    assert!(known.len() > 50, "{}", known.len());
    for told in known {
        assert_eq!(told.angles.len(), GROUPS);
        let pairs = told.angles[..40].iter().zip(&told.angles[54..]);
        assert!(
            pairs.into_iter().all(|(a, b)| (a + 2.0 * b).abs() < 1e-5),
            "{told:?}"
        );
    }
    let answer = folder.done("stream wide.traj --to sim --json");
    assert_eq!(answer.json()["outcome"], "done");
}

#[test]
fn a_stop_brakes_along_the_path_and_resuming_goes_on_from_there() {
    let folder = small();
    let (path, bytes) = (
        read(&folder),
        std::fs::read(folder.path("path.traj")).unwrap(),
    );
    let mut sim = Sim::new();
    let stop = |heard: &[Telemetry]| {
        if heard.len() < 40 {
            Wish::Run
        } else {
            Wish::Stop
        }
    };
    let (summary, heard) = session(&mut sim, &path, (1, false), &stop);
    assert_eq!(summary.outcome, Outcome::Stopped, "{summary:?}");
    let stood = heard.last().unwrap();
    assert_eq!((stood.state, stood.rate.to_bits()), (State::Holding, 0));
    assert!(stood.place.knot < 4 && stood.place.into > 0.0, "{stood:?}");
    let rates: Vec<f32> = heard.iter().rev().map(|told| told.rate).collect();
    let braking = rates
        .iter()
        .filter(|rate| **rate > 0.0 && **rate < 1.0)
        .count();
    // The rate changes by 4 per second, so braking takes a quarter of a second: twelve messages at 20 ms. The start has
    // twelve messages as well.
    assert!((22..=26).contains(&braking), "{braking}");

    // Without `--resume` the hold stays.
    let (summary, _) = session(&mut sim, &path, (2, false), &|_| Wish::Run);
    assert_eq!(summary.outcome, Outcome::Held, "{summary:?}");
    assert_eq!(summary.reason, Some(Ending::Held(Reason::HoldCommand)));

    let (summary, heard) = session(&mut sim, &path, (3, true), &|_| Wish::Run);
    assert_eq!(summary.outcome, Outcome::Done, "{summary:?}");
    let begin = heard
        .iter()
        .find(|told| told.state == State::Running)
        .unwrap();
    let passed = begin.place.into - stood.place.into;
    assert_eq!(begin.place.knot, stood.place.knot);
    assert!((0.0..0.002).contains(&passed), "{passed}");
    for told in heard.iter().filter(|told| !told.angles.is_empty()) {
        assert_eq!(bits(&told.angles), bits(&at(&bytes, told.place)));
    }
    // Nothing is left to do, so the outcome is done.
    let (summary, _) = session(&mut sim, &path, (4, true), &|_| Wish::Run);
    assert_eq!(summary.outcome, Outcome::Done, "{summary:?}");
}

/// A sheet that a hand has taken back along its path goes on from where it stands, slowly, and not from where it was. Without
/// `--resume` nothing moves.
#[test]
fn a_sheet_that_was_moved_along_its_path_goes_on_from_there() {
    let folder = small();
    let bytes = std::fs::read(folder.path("path.traj")).unwrap();
    let path = read(&folder);
    let mut sim = Sim::driving(Plant::new(&path, Drive::default(), 1, Vec::new()));
    let stop = |heard: &[Telemetry]| {
        let folds = |told: &Telemetry| told.angles.iter().any(|angle| angle.abs() > 1.2);
        if heard.last().is_some_and(folds) {
            Wish::Stop
        } else {
            Wish::Run
        }
    };
    let (_, heard) = session(&mut sim, &path, (1, false), &stop);
    let stood = heard.last().unwrap();
    let mut back = stood.place;
    (back.knot, back.into) = (back.knot / 2, 0.01);
    let there = at(&bytes, back);
    let way = there.iter().zip(&stood.angles).map(|(to, from)| to - from);
    let way: Vec<f32> = way.collect();
    assert!(way.iter().any(|by| by.abs() > 0.3), "{way:?}");
    // The supply fails, and a hand turns all hinges.
    let plant = sim.plant_mut().unwrap();
    plant.befall(Trouble::Supply(0.0));
    for (hinge, membership) in path.hinges().iter().enumerate() {
        let by = membership.apply(way[membership.group.index()]);
        plant.befall(Trouble::Turn(hinge, by.into()));
    }
    (0..200).for_each(|_| sim.wait().unwrap());
    sim.plant_mut().unwrap().befall(Trouble::Supply(1.0));
    let (summary, _) = session(&mut sim, &path, (3, false), &|_| Wish::Run);
    assert_eq!(summary.outcome, Outcome::Faulted, "{summary:?}");
    let (summary, heard) = session(&mut sim, &path, (5, true), &|_| Wish::Run);
    assert_eq!(summary.outcome, Outcome::Done, "{summary:?}");
    let begun = heard.iter().find(|told| !told.angles.is_empty()).unwrap();
    for (angle, there) in begun.angles.iter().zip(&there) {
        assert!((angle - there).abs() < 0.02, "{begun:?} {there}");
    }
    let closure = summary.max_closure;
    assert!(closure <= path.max_reported_closure(), "{closure}");
}

#[test]
fn leaving_draws_the_stop_line_that_holds_until_it_is_let_go() {
    let path = read(&small());
    let mut sim = Sim::new();
    let quit = |heard: &[Telemetry]| {
        if heard.len() < 40 {
            Wish::Run
        } else {
            Wish::Quit
        }
    };
    let (summary, heard) = session(&mut sim, &path, (1, false), &quit);
    assert_eq!(summary.outcome, Outcome::Stopped, "{summary:?}");
    assert_eq!(summary.reason, Some(Ending::Quit { reported: true }));
    let rate = heard.last().unwrap().rate;
    assert!(rate > 0.99 || rate <= 0.0, "{rate}");
    for resume in [false, true] {
        let (summary, _) = session(&mut sim, &path, (2 + u32::from(resume), resume), &|_| {
            Wish::Run
        });
        assert_eq!(summary.outcome, Outcome::Held, "{summary:?}");
        assert_eq!(summary.reason, Some(Ending::Held(Reason::StopLine)));
    }
}

pub(crate) type Device = Controller<4, 64, 64, 16>;

/// A controller behind a stream of bytes. It keeps running when its host disconnects, and its clock is real time.
pub(crate) struct Served {
    device: Device,
    start: Instant,
    /// Knot at which the controller is, for the test to read.
    knot: Arc<AtomicU32>,
}

/// Returns a controller that is told that both groups stand at 0, where the path begins.
fn flat() -> Device {
    let limits = |_| GroupLimits {
        lower: -3.2,
        upper: 3.2,
        speed: 20.0,
        acceleration: f32::INFINITY,
    };
    let mut device = Device::protected(Settings::new([1, 0], limits), Unkeyed);
    let place = FollowerPosition::default();
    device
        .follower_mut()
        .stand(&[0.0; 2], place, false)
        .unwrap();
    device
}

impl Served {
    fn new() -> Self {
        Self {
            device: flat(),
            start: Instant::now(),
            knot: Arc::default(),
        }
    }

    /// Serves until the other end disconnects, or `until` returns `true`.
    fn serve(&mut self, mut line: impl Read + Write, until: impl Fn(&Device) -> bool) {
        let (mut buffer, mut outgoing) = ([0; 256], Vec::new());
        while !until(&self.device) {
            let now = u64::try_from(self.start.elapsed().as_micros()).unwrap();
            match line.read(&mut buffer) {
                Ok(0) => return,
                Ok(count) => buffer[..count]
                    .iter()
                    .for_each(|byte| self.device.byte(*byte, now)),
                Err(error) if is_pause(&error) => sleep(Duration::from_micros(500)),
                Err(_) => return,
            }
            self.device.tick(now);
            self.device.drive(|_, _, _| None);
            self.device.poll(now);
            self.knot
                .store(self.device.follower().position().knot, Ordering::Relaxed);
            outgoing.extend(core::iter::from_fn(|| self.device.take()));
            match line.write(&outgoing) {
                Ok(count) => drop(outgoing.drain(..count)),
                Err(error) if is_pause(&error) => {}
                Err(_) => return,
            }
        }
    }
}

/// A host that waits for as long as it takes says what it waits for, once.
#[test]
#[cfg(unix)]
fn a_host_that_waits_says_what_for() {
    let folder = small();
    let lease = |device: &mut Device| {
        let place = FollowerPosition { knot: 0, into: 0.1 };
        device.follower_mut().lease(Some(place));
    };
    let (port, _, thread) = served(1, |_| false, lease);
    let mut host = folder.command(&format!(
        "stream path.traj --to tcp:{port} --insecure --json"
    ));
    let host = host.stdout(Stdio::piped()).stderr(Stdio::piped());
    let host = host.spawn().unwrap();
    sleep(Duration::from_millis(4000));
    let id = host.id().to_string();
    let kill = std::process::Command::new("kill")
        .args(["-INT", &id])
        .status();
    assert!(kill.unwrap().success());
    let output = host.wait_with_output().unwrap();
    let json: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(json["outcome"], "stopped", "{json}");
    let said = String::from_utf8(output.stderr).unwrap();
    let note = "note: the motion is slow or at rest: the motion has reached its bound";
    assert_eq!(said.lines().collect::<Vec<_>>(), [note]);
    thread.join().unwrap();
}

/// A fault does not hide that the stop line holds as well; once the fault is cleared, the stop line is what is told.
#[test]
fn a_stop_line_behind_a_fault_is_told() {
    let folder = small();
    let (port, _, thread) = served(
        2,
        |_| false,
        |device| {
            device.follower_mut().fail(Fault::Stalled(3));
            device.stop(true);
        },
    );
    let stream = format!("stream path.traj --to tcp:{port} --insecure --json");
    let json = folder.run(&stream).with_status(1).json();
    assert_eq!(json["outcome"], "faulted", "{json}");
    let reason = json["reason"].as_str().unwrap();
    assert!(
        reason.contains("hinge 3") && reason.contains("stop line"),
        "{reason}"
    );
    let json = folder
        .run(&format!("{stream} --resume"))
        .with_status(1)
        .json();
    assert_eq!(json["outcome"], "held", "{json}");
    assert!(
        json["reason"]
            .as_str()
            .unwrap()
            .starts_with("the stop line")
    );
    thread.join().unwrap();
}

fn is_pause(error: &io::Error) -> bool {
    use ErrorKind::{TimedOut, WouldBlock};
    matches!(error.kind(), WouldBlock | TimedOut)
}

/// Starts a controller, prepared by `prepare`, that serves `hosts` hosts, one after the other, at a port.
pub(crate) fn served(
    hosts: usize,
    until: fn(&Device) -> bool,
    prepare: fn(&mut Device),
) -> (u16, Arc<AtomicU32>, JoinHandle<Device>) {
    let listener = TcpListener::bind(("127.0.0.1", 0)).unwrap();
    let port = listener.local_addr().unwrap().port();
    let mut served = Served::new();
    prepare(&mut served.device);
    let knot = Arc::clone(&served.knot);
    let thread = thread::spawn(move || {
        for stream in listener.incoming().take(hosts) {
            let stream = stream.unwrap();
            stream.set_nonblocking(true).unwrap();
            stream.set_nodelay(true).unwrap();
            served.serve(stream, until);
        }
        served.device
    });
    (port, knot, thread)
}

/// Whatever ends the host, the log has all rows that had come, each whole.
#[test]
#[cfg(unix)]
fn a_killed_host_leaves_a_log_of_whole_rows() {
    let folder = small();
    let (port, knot, thread) = served(1, |_| false, |_| {});
    let stream = format!("stream path.traj --to tcp:{port} --insecure --log log.csv");
    let mut host = folder.command(&stream).spawn().unwrap();
    while knot.load(Ordering::Relaxed) < 2 {
        sleep(Duration::from_millis(1));
    }
    host.kill().unwrap();
    host.wait().unwrap();
    thread.join().unwrap();
    let log = folder.read("log.csv");
    assert!(log.ends_with('\n'), "{log}");
    let columns = log.lines().next().unwrap().split(',').count();
    let whole = |line: &str| line.split(',').count() == columns;
    assert!(log.lines().all(whole), "{log}");
    let last = log.lines().last().unwrap();
    assert!(
        log.lines().count() > 10 && last.contains("Running"),
        "{log}"
    );
}

#[test]
fn a_controller_behind_tcp_is_stopped_by_ctrl_c_and_goes_on() {
    let folder = small();
    let bytes = std::fs::read(folder.path("path.traj")).unwrap();
    let (port, knot, thread) = served(2, |_| false, |_| {});
    let stream = format!("stream path.traj --to tcp:{port} --insecure --unattended --json --log");
    let mut host = folder.command(&format!("{stream} first.csv"));
    let host = host
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    while knot.load(Ordering::Relaxed) < 1 {
        sleep(Duration::from_millis(1));
    }
    let id = host.id().to_string();
    let kill = std::process::Command::new("kill")
        .args(["-INT", &id])
        .status();
    assert!(kill.unwrap().success());
    let output = host.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(1));
    let json: Value = serde_json::from_slice(&output.stdout).unwrap();
    assert_eq!(json["outcome"], "stopped", "{json}");
    let first = rows(&folder.read("first.csv"));
    assert_eq!(first.last().unwrap().state, "Holding");

    let json = folder.done(&format!("{stream} second.csv --resume")).json();
    assert_eq!(json["outcome"], "done");
    let second = rows(&folder.read("second.csv"));
    assert_eq!(second.last().unwrap().state, "Done");
    assert!(second[0].sequence >= 1);
    assert_eq!(bits(&second[0].angles), bits(&first.last().unwrap().angles));
    // The controller is on the path bit by bit, and has executed no part of it twice.
    let device = thread.join().unwrap();
    let goal = at(&bytes, device.follower().position());
    assert_eq!(bits(device.follower().angles()), bits(&goal));
    assert_eq!(device.follower().state(), State::Done);
}

/// A line whose other end may not be open yet: errors only mean that there is nothing to read or write.
struct Patient<S>(S);

impl<S: Read> Read for Patient<S> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        self.0
            .read(buffer)
            .map_err(|_| ErrorKind::WouldBlock.into())
    }
}

impl<S: Write> Write for Patient<S> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0
            .write(bytes)
            .map_err(|_| ErrorKind::WouldBlock.into())
    }

    fn flush(&mut self) -> io::Result<()> {
        self.0.flush()
    }
}

#[test]
#[cfg(unix)]
fn a_controller_behind_a_serial_device_is_done_with_faults_too() {
    use serialport::{SerialPort, TTYPort};
    let folder = small();
    let (mut board, host) = TTYPort::pair().unwrap();
    board.set_timeout(Duration::ZERO).unwrap();
    let name = host.name().unwrap();
    let over = Arc::new(AtomicBool::new(false));
    let end = Arc::clone(&over);
    let thread = thread::spawn(move || {
        let mut served = Served::new();
        served.serve(Patient(board), |_| end.load(Ordering::Relaxed));
        served.device.follower().state()
    });
    drop(host);
    let faults = "drop=0.05,flip=0.05,double=0.05,seed=3";
    // A machine that is busy may let its host fall silent for a while.
    let stream =
        format!("stream path.traj --to serial:{name} --unattended --json --faults {faults}");
    let json = folder.done(&stream).json();
    assert_eq!(json["outcome"], "done", "{json}");
    over.store(true, Ordering::Relaxed);
    assert_eq!(thread.join().unwrap(), State::Done);
}

#[test]
fn a_line_that_breaks_and_one_that_is_not_there_are_no_device() {
    let folder = small();
    let (port, _, thread) = served(1, |device| device.follower().position().knot >= 1, |_| {});
    let stream = format!("stream path.traj --to tcp:{port} --insecure --json");
    let json = folder.run(&stream).with_status(1).json();
    assert_eq!(json["outcome"], "no_device", "{json}");
    assert!(
        json["reason"].as_str().unwrap().starts_with("the line: "),
        "{json}"
    );
    assert!(json["setpoints"].as_u64().unwrap() > 1);
    drop(thread.join().unwrap());
    for (target, reason) in [
        (format!("tcp:{port}"), format!("tcp:{port}: ")),
        (
            format!("tcp:127.0.0.1:{port}"),
            format!("tcp:127.0.0.1:{port}: "),
        ),
        ("serial:nowhere".into(), "serial:nowhere: ".into()),
    ] {
        let insecure = if target.starts_with("tcp") {
            "--insecure"
        } else {
            ""
        };
        let stream = format!("stream path.traj --json --to {target} {insecure}");
        let json = folder.run(&stream).with_status(1).json();
        assert_eq!(json["outcome"], "no_device", "{json}");
        let found = json["reason"].as_str().unwrap();
        assert!(found.starts_with(&reason), "{found}");
        assert_eq!(json["bytes_sent"], 0);
    }
}

#[test]
fn a_controller_of_another_version_is_no_device() {
    let folder = small();
    let listener = TcpListener::bind(("127.0.0.1", 0)).unwrap();
    let port = listener.local_addr().unwrap().port();
    let thread = thread::spawn(move || {
        let (mut stream, _) = listener.accept().unwrap();
        let mut deframer = cobs::Deframer::<256>::default();
        let (mut byte, mut buffer) = ([0], [0; 64]);
        while stream.read(&mut byte).unwrap_or(0) > 0 {
            let frame = deframer.push(byte[0]).and_then(frame::open);
            let Some((0, foldpath_core::wire::message::ToDevice::Hello { id, .. })) = frame else {
                continue;
            };
            let (version, schema) = (9, 0xabcd_ef01);
            let answer = ToHost::Mismatch {
                id,
                version,
                schema,
            };
            let mut bytes = Vec::new();
            let answer = frame::seal(0, &answer, &mut buffer).unwrap();
            cobs::encode(answer, |byte| bytes.push(byte));
            let _gone = stream.write_all(&bytes);
        }
    });
    let stream = format!("stream path.traj --to tcp:{port} --insecure --json");
    let json = folder.run(&stream).with_status(1).json();
    assert_eq!(json["outcome"], "no_device");
    let reason = json["reason"].as_str().unwrap();
    assert!(
        reason.starts_with("the controller speaks version 9 (abcdef01)"),
        "{reason}"
    );
    thread.join().unwrap();
}

/// Returns a path of two groups with a star that closes only if both groups are flat.
fn made(speed: f32, angles: [f32; 2], closure: f32) -> Vec<u8> {
    let spoke = |(group, direction)| Spoke {
        group: GroupId(group),
        negative: false,
        direction,
    };
    let spokes = [(0, [1.0, 0.0]), (1, [0.0, 1.0])].map(spoke);
    let limits = GroupLimits {
        lower: -3.0,
        upper: 3.0,
        speed,
        acceleration: f32::INFINITY,
    };
    let numbers = [[0.0; 2], angles].concat();
    let view = TrajectoryView::new(
        Interpolation::Hermite,
        2,
        &[0.0, 1.0],
        &numbers,
        &[0.0; 4],
        &[],
    );
    let stars = StarsView::new(&spokes, &[2], 2).unwrap();
    let mut bytes = Vec::new();
    let sink = |part: &[u8]| bytes.extend_from_slice(part);
    write(
        view.unwrap(),
        &[limits; 2],
        &[],
        stars,
        closure,
        LagCost::UNKNOWN,
        sink,
    )
    .unwrap();
    bytes
}

#[test]
fn what_the_controller_refuses_holds_and_is_told() {
    let folder = folder();
    // A path that tears the sheet is not sent at all.
    for angles in [[0.0, 1.0], [1e-5, 1.0]] {
        std::fs::write(folder.path("open.traj"), made(1.0, angles, 1e-4)).unwrap();
        let refused = folder
            .run("stream open.traj --to sim --json")
            .with_status(2);
        let error = &refused.json()["error"]["message"];
        let expected = "open.traj: segment before knot 1: expected essential vertices that stay closed within 1e-4";
        assert!(error.as_str().unwrap().starts_with(expected), "{error}");
    }
    for (speed, angles, closure, reason) in [
        (
            0.1,
            [0.0, 0.5],
            1.0,
            "the sheet was refused: its path is open by more than",
        ),
        (
            1e-5,
            [0.0, 9e-5],
            9e-4,
            "knot 1 was refused: group 1: too fast",
        ),
    ] {
        std::fs::write(folder.path("bad.traj"), made(speed, angles, closure)).unwrap();
        let json = folder
            .run("stream bad.traj --to sim --json")
            .with_status(1)
            .json();
        assert_eq!(
            (&json["outcome"], &json["refused"]),
            (&"held".into(), &1.into()),
            "{json}"
        );
        let found = json["reason"].as_str().unwrap();
        assert!(found.starts_with(reason), "{found}");
    }
}

#[test]
fn bad_files_and_usage_are_told() {
    let folder = small();
    let good = std::fs::read(folder.path("path.traj")).unwrap();
    let mut old = good.clone();
    old[4] = 1;
    let mut changed = good.clone();
    changed[100] ^= 1;
    std::fs::write(folder.path("old.traj"), old).unwrap();
    std::fs::write(folder.path("changed.traj"), changed).unwrap();
    std::fs::write(folder.path("short.traj"), &good[..good.len() - 9]).unwrap();
    folder.write("empty.traj", "");
    folder.write("script.txt", "1 supply 0.5\n1 stick 12\n");
    folder.done("generate miura --rows 2 --cols 3 -o flat.fold");
    folder.done("plan flat.fold -o other.fold");
    for (arguments, message) in [
        (
            "path.fold --to sim",
            "path.fold: byte 0: expected the magic number FPTJ",
        ),
        (
            "old.traj --to sim",
            "old.traj: byte 4: expected version 2 to 4, found 1",
        ),
        ("changed.traj --to sim", "changed.traj: "),
        ("short.traj --to sim", "short.traj: byte "),
        ("empty.traj --to sim", "empty.traj: byte 0: the file ends"),
        ("none.traj --to sim", "none.traj: "),
        (
            "path.traj --to sim --log path.traj",
            "--log: path.traj is an input file",
        ),
        ("path.traj --to sim --log no/log.csv", "no/log.csv: "),
        (
            "path.traj --to sim --script script.txt",
            "script.txt: line 2: expected SECONDS and supply 0..1, stick HINGE, free HINGE, jump HINGE RADIANS or turn \
             HINGE RADIANS, with hinges below 12, found 1 stick 12",
        ),
        ("path.traj --to sim --script none.txt", "none.txt: "),
        (
            "path.traj --to sim --sheet other.fold",
            "other.fold: foldpath:edges_group: expected the 12 hinges of the path that is sent, found 7 hinges",
        ),
        (
            "path.traj --to tcp:1 --drives lag=1",
            "--drives, --script and --sheet: expected --to sim",
        ),
        (
            "path.traj --to qemu",
            "--to qemu: no image: expected --image FILE, which `cargo build",
        ),
    ] {
        let answer = folder.run(&format!("stream {arguments}")).with_status(2);
        assert!(answer.begins(message), "{answer:?}");
        assert_eq!(answer.stdout, "");
    }
    for (drives, message) in [
        (
            "mass=1",
            "expected lag, speed, acceleration, play, noise or seed, found mass",
        ),
        ("lag=-1", "lag: expected 0 or more, found -1"),
        ("lag", "expected KEY=VALUE, found lag"),
    ] {
        let stream = format!("stream path.traj --to sim --drives {drives}");
        let answer = folder.run(&stream).with_status(2);
        assert!(answer.stderr.contains(message), "{answer:?}");
    }
    let answer = folder.run("stream path.traj --to usb").with_status(2);
    assert!(
        answer.stderr.contains("expected sim, qemu, serial:DEVICE"),
        "{answer:?}"
    );
    let names = folder.names();
    assert!(!names.iter().any(|name| name.contains("log")), "{names:?}");
}

//! Is nothing forgotten by resets, faults and other sheets, with 2, 11 and 94 groups, and does work go on afterwards?

use foldpath_core::follower::{Denial, Fault, Reason, State};
use foldpath_core::wire::cobs;
use foldpath_core::wire::driver::{Driver, Persistence};
use foldpath_core::wire::message::{Command, ItemRefusal, Report};
use foldpath_core::wire::path::PathItems;
use foldpath_core::wire::sender::Options;

use crate::machine::{EXACT, Machine, Path, ROUND, told};

/// A warm reset at 20 moments, with the stop line drawn or not: place, angles and stop are kept, and the fold goes on.
fn a_reset_forgets_nothing<const G: usize>() {
    let path = Path::new(G);
    for moment in 0..20 {
        for stop in [false, true] {
            let mut machine = Machine::<G>::new(1);
            let mut host = path.driver(Persistence::None, 7).confirming();
            machine.run(Some(&mut host), 400 + 80 * moment);
            machine.bench(|bench| bench.stop = stop);
            machine.run(Some(&mut host), 3);
            let stood = machine.command().unwrap();
            machine.bench(|bench| bench.stop = false);
            machine.reset();
            machine.run(None, 100);
            let condition = machine.condition();
            assert_eq!((condition.stopped, condition.known), (stop, true));
            // Nobody has sent the hinges again: the board knows that none has a command.
            assert_eq!(condition.commanded, 0);
            let mut host = path.driver(Persistence::None, 8);
            machine.run(Some(&mut host), 300);
            if stop {
                assert_eq!(told(&host).reason, Reason::StopLine);
            } else {
                assert_eq!(host.sender().answer(), Some(Err(Denial::Jump(0))));
            }
            assert_eq!(machine.command(), Some(stood));
            // The first try goes on, also after a stop line.
            let mut host = path.driver(Persistence::Resume, 9);
            machine.run(Some(&mut host), 3500);
            assert_eq!(
                (told(&host).state, stop),
                (State::Done, stop),
                "{:?}",
                host.sender()
            );
        }
    }
}

#[test]
fn a_reset_forgets_neither_the_place_nor_the_stop_line() {
    a_reset_forgets_nothing::<2>();
    a_reset_forgets_nothing::<11>();
    a_reset_forgets_nothing::<94>();
}

/// The stop line is drawn while a hinge has stalled. Both are told and kept over a reset, and so is the place on the path.
/// The stuck hinge is elsewhere, so that it is not known where the sheet stands until its hinges are measured again.
fn a_stop_in_a_fault_is_kept<const G: usize>() {
    let path = Path::new(G);
    let mut machine = Machine::<G>::new(1);
    machine.bench(|bench| {
        bench.sensor = Some(|hinge, angle, _| match angle {
            Some(angle) if hinge == 3 => angle.clamp(-0.3, 0.3),
            angle => angle.unwrap_or(0.0),
        });
    });
    let mut host = path.driver(Persistence::None, 7);
    machine.run(Some(&mut host), 3000);
    let fault = Fault::Stalled(3);
    assert_eq!(told(&host).reason, Reason::Fault(fault));
    let (stood, place) = (machine.bench(|bench| -bench.stands[0]), told(&host).place);
    machine.bench(|bench| bench.stop = true);
    machine.run(Some(&mut host), 10);
    machine.bench(|bench| bench.stop = false);
    machine.run(Some(&mut host), 50);
    let is_kept = |machine: &Machine<G>, host: &Driver<'_>| {
        let condition = machine.condition();
        assert_eq!(
            (condition.fault, condition.stopped, condition.known),
            (Some(fault), true, false)
        );
        let report = told(host);
        assert_eq!(
            (report.reason, report.stopped, report.known),
            (Reason::Fault(fault), true, false)
        );
        assert_eq!(report.place, place);
        assert_eq!(condition.commanded, 0);
    };
    is_kept(&machine, &host);
    machine.reset();
    let mut host = path.driver(Persistence::None, 8);
    // Longer than the half of `fresh` for which sensors have to agree with the record of a sheet without a fault.
    machine.run(Some(&mut host), 600);
    is_kept(&machine, &host);
    machine.bench(|bench| bench.sensor = Some(EXACT));
    let mut host = path.driver(Persistence::Resume, 9);
    machine.run(Some(&mut host), 1500);
    assert!(machine.command().unwrap() >= stood - 0.1);
    machine.run(Some(&mut host), 3500);
    assert_eq!(told(&host).state, State::Done);
}

#[test]
fn a_stop_line_that_is_drawn_in_a_fault_is_told_and_kept() {
    a_stop_in_a_fault_is_kept::<2>();
    a_stop_in_a_fault_is_kept::<11>();
    a_stop_in_a_fault_is_kept::<94>();
}

/// Hinges are commanded where they stand after `Unload`, after a fault was cleared, and while another sheet comes or is
/// refused, until the other sheet is complete.
#[test]
fn hinges_are_owned_until_another_sheet_is_complete() {
    use foldpath_core::wire::message::Item;
    use foldpath_core::wire::sender::{Sender, Source};
    /// The first items of a path.
    struct Part<'a>(PathItems<'a>, u64);
    impl Source for Part<'_> {
        fn item<'b>(&self, index: u64, scratch: &'b mut [u8]) -> Option<Item<'b>> {
            (index < self.1)
                .then(|| self.0.item(index, scratch))
                .flatten()
        }
    }
    fn talk<const G: usize>(
        machine: &mut Machine<G>,
        id: u32,
        source: &impl Source,
        command: Option<Command>,
    ) -> Report {
        let mut sender = Sender::new(id, Options::default());
        command.map(|command| sender.command(command));
        let mut deframer = cobs::Deframer::<512>::default();
        for _ in 0..400 {
            let (now, sent) = machine.bench(|bench| {
                bench.now += ROUND;
                (bench.now, core::mem::take(&mut bench.sent))
            });
            machine.controller.step();
            for byte in sent {
                if let Some(frame) = deframer.push(byte) {
                    sender.receive(frame, now);
                }
            }
            let (mut scratch, mut buffer) = ([0; 256], [0; 256]);
            while let Some(frame) = sender.poll(now, source, &mut scratch, &mut buffer) {
                cobs::encode(frame, |byte| {
                    machine.bench(|bench| bench.received.push_back(byte))
                });
            }
        }
        *sender.report().unwrap()
    }
    let path = Path::new(11);
    let mut machine = Machine::<11>::new(1);
    let mut host = path.driver(Persistence::None, 7).confirming();
    machine.run(Some(&mut host), 1000);
    host.stop();
    machine.run(Some(&mut host), 400);
    let stood = machine.bench(|bench| bench.commands.clone());
    assert_eq!(stood.iter().flatten().count(), 33);
    let still = |machine: &Machine<11>| machine.bench(|bench| bench.commands == stood);
    let nothing = Part(path.items(), 0);
    assert_eq!(
        talk(&mut machine, 8, &nothing, Some(Command::Unload)).state,
        State::Idle
    );
    assert!(still(&machine));
    // A sheet of more hinges than there is room for, and the head and limits of a sheet that fits.
    let wide = Path::new(94);
    let refused = talk(&mut machine, 9, &Part(wide.items(), 99), None).refused;
    assert_eq!(refused, Some(ItemRefusal::Room));
    assert!(still(&machine));
    let other = Path::new(5);
    talk(
        &mut machine,
        10,
        &Part(other.items(), other.items().head() as u64),
        None,
    );
    assert!(still(&machine));
    // With its first setpoint the other sheet is complete; nobody knows where it stands.
    let whole = Part(other.items(), other.items().head() as u64 + 1);
    let report = talk(&mut machine, 11, &whole, None);
    assert_eq!((report.state, report.known), (State::Ready, false));
    assert_eq!(machine.bench(|bench| bench.commands.clone()), [None; 15]);
    // It hangs flat on the board, and folds without a power cycle, once an operator undoes the hold.
    machine.bench(|bench| bench.stands.fill(0.0));
    machine.run(
        Some(&mut other.driver(Persistence::None, 12).confirming()),
        3500,
    );
    assert_eq!(machine.condition().state, State::Ready);
    machine.run(
        Some(&mut other.driver(Persistence::Resume, 13).confirming()),
        3500,
    );
    assert_eq!(machine.condition().state, State::Done);
    // After a fault as well.
    machine.bench(|bench| bench.sensor = Some(|_, _, _| f32::NAN));
    let back = Path::from(5, 2.0, -1.0);
    machine.run(Some(&mut back.driver(Persistence::None, 14)), 2500);
    assert_eq!(machine.condition().state, State::Faulted);
    let stood = machine.bench(|bench| bench.commands.clone());
    talk(&mut machine, 15, &nothing, Some(Command::Clear));
    assert_eq!(machine.condition().state, State::Idle);
    assert_eq!(machine.bench(|bench| bench.commands.clone()), stood);
}

/// The stop line is drawn and let go in the middle of a fold; the first `--resume` goes on.
#[test]
fn the_first_resume_after_a_stop_line_goes_on() {
    for moment in 0..20 {
        let path = Path::new(2);
        let mut machine = Machine::<2>::new(1);
        let mut host = path.driver(Persistence::None, 7).confirming();
        machine.run(Some(&mut host), 400 + 80 * moment);
        machine.bench(|bench| bench.stop = true);
        machine.run(Some(&mut host), 20);
        machine.bench(|bench| bench.stop = false);
        machine.run(Some(&mut host), 700);
        let mut host = path.driver(Persistence::Resume, 8);
        for _ in 0..3500 {
            machine.run(Some(&mut host), 1);
            assert_ne!(host.sender().answer(), Some(Err(Denial::Held)));
        }
        assert_eq!(told(&host).state, State::Done);
    }
}

/// The way back is another path: nobody takes a place on the one for a place on the other.
#[test]
fn a_place_belongs_to_its_path() {
    let (path, back) = (Path::new(2), Path::from(2, 2.0, -1.0));
    let mut machine = Machine::<2>::new(1);
    let mut host = path.driver(Persistence::None, 7).confirming();
    machine.run(Some(&mut host), 1000);
    host.stop();
    machine.run(Some(&mut host), 400);
    let mut other = back.driver(Persistence::Resume, 8);
    machine.run(Some(&mut other), 300);
    assert!(other.off_path().is_some());
    let mut host = path.driver(Persistence::Resume, 9);
    machine.run(Some(&mut host), 3000);
    assert_eq!(told(&host).state, State::Done);
    let mut other = back.driver(Persistence::None, 10);
    machine.run(Some(&mut other), 3500);
    assert_eq!(told(&other).state, State::Done);
    assert!(machine.command().unwrap().abs() < 1e-6);
}

/// The drives are limp in a reset, and the sheet moves a little by itself. With sensors the fold goes on from where the
/// sheet stands; without, nobody knows where that is.
fn limp_drives_tell_no_place<const G: usize>() {
    let path = Path::new(G);
    for (moment, (senses, off)) in [(true, 0.02), (true, -0.05), (true, 0.3), (false, 0.05)]
        .into_iter()
        .enumerate()
    {
        let mut machine = Machine::<G>::new(1);
        let mut host = path.driver(Persistence::None, 7).confirming();
        machine.run(Some(&mut host), 600 + 200 * moment as u64);
        let stood = machine.command().unwrap();
        machine.bench(|bench| {
            bench.limp = true;
            bench.sensor = senses.then_some(EXACT);
            for (hinge, stands) in bench.stands.iter_mut().enumerate() {
                *stands += path.hinges[hinge].apply(off);
            }
        });
        machine.reset();
        machine.run(None, 50);
        assert!(!machine.condition().known);
        // A second reset does not make the place known again.
        machine.reset();
        let mut host = path.driver(Persistence::Resume, 8);
        machine.run(Some(&mut host), 200);
        let goes_on = senses && off < 0.1;
        if !goes_on {
            machine.run(Some(&mut host), 300);
            let denied = host.sender().answer().unwrap().unwrap_err();
            let expected = if senses {
                matches!(denied, Denial::Jump(0) | Denial::Unknown(0))
            } else {
                denied == Denial::Unknown(0)
            };
            assert!(expected, "{denied:?}");
            assert_eq!((told(&host).state, machine.command()), (State::Ready, None));
            continue;
        }
        let command = machine.command().unwrap();
        assert!((command - stood - off).abs() < 0.02, "{command} {stood}");
        machine.run(Some(&mut host), 4000);
        assert_eq!(told(&host).state, State::Done);
    }
}

#[test]
fn drives_that_were_limp_in_a_reset_tell_no_place() {
    limp_drives_tell_no_place::<2>();
    limp_drives_tell_no_place::<11>();
    limp_drives_tell_no_place::<94>();
}

/// A reset, or the end of the host's patience, comes in the middle of an approach.
#[test]
fn an_approach_is_stopped_by_its_host_and_goes_on_behind_a_reset() {
    let path = Path::from(11, 0.08, 1.0);
    for moment in 0..20 {
        let mut machine = Machine::<11>::new(1);
        machine.bench(|bench| bench.sensor = Some(EXACT));
        let mut host = path.driver(Persistence::None, 7);
        machine.run(Some(&mut host), 150 + 35 * moment);
        assert_eq!(told(&host).reason, Reason::Approach, "{moment}");
        host.stop();
        machine.run(Some(&mut host), 400);
        assert_eq!(
            (told(&host).state, told(&host).reason),
            (State::Holding, Reason::HoldCommand)
        );
        let stood = machine.command().unwrap();
        machine.run(Some(&mut host), 100);
        assert_eq!(machine.command(), Some(stood));
        assert!(stood < 0.08);
        if moment % 2 == 0 {
            machine.reset();
        }
        let mut host = path.driver(Persistence::Resume, 8);
        machine.run(Some(&mut host), 5000);
        assert_eq!(told(&host).state, State::Done, "{:?}", told(&host));
    }
}

//! Does a path in flash play as that of a host does, and does a button move nothing that a host could not move?

use foldpath_controller::{PlayRefusal, Player, PlayerError};
use foldpath_core::follower::{Denial, Fault, FollowerPosition, Reason, State};
use foldpath_core::trajectory_file::FileError;
use foldpath_core::wire::driver::{Driver, Persistence};
use foldpath_core::wire::sender::{Failure, Options, Phase};

use crate::machine::{EXACT, Machine};
use crate::path::{KNOTS, Path};

/// A board with a button, and what its first hinge was commanded in each tick.
struct Desk<'a> {
    machine: Machine<2>,
    player: Player<'a>,
    commands: Vec<u32>,
}

impl<'a> Desk<'a> {
    fn new(there: &'a [u8], back: Option<&'a [u8]>) -> Self {
        Self {
            machine: Machine::new(1),
            player: Player::new(there, back).unwrap(),
            commands: Vec::new(),
        }
    }

    fn run(&mut self, mut host: Option<&mut Driver<'_>>, millis: u64) {
        for _ in 0..millis {
            self.machine.run(host.as_deref_mut(), 1);
            self.machine.controller.play(&mut self.player);
            self.commands
                .extend(self.machine.command().map(f32::to_bits));
        }
    }

    fn press(&mut self) -> Option<PlayRefusal> {
        self.player.press();
        self.run(None, 1);
        self.player.refused()
    }

    fn press_flat(&mut self) -> Option<PlayRefusal> {
        self.player.press_flat();
        self.run(None, 1);
        self.player.refused()
    }

    fn release(&mut self) -> Option<PlayRefusal> {
        self.player.release();
        self.run(None, 1);
        self.player.refused()
    }

    /// Starts the path from the flat sheet and runs it to its middle.
    fn half(&mut self) {
        assert_eq!(self.press_flat(), None);
        self.run(None, 2200);
        assert_eq!(self.player.refused(), None);
        assert_eq!(self.state(), State::Running);
        assert!(self.machine.command().unwrap() > 0.5);
    }

    /// Runs on to the end of the path.
    fn finish(&mut self) {
        self.run(None, 4000);
        assert_eq!((self.player.refused(), self.state()), (None, State::Done));
        assert!(!self.player.is_playing());
    }

    /// Asserts that nothing moves for a while.
    fn rests(&mut self) {
        let before = self.machine.bench(|bench| bench.stands.clone());
        self.run(None, 2000);
        self.machine.bench(|bench| assert_eq!(bench.stands, before));
    }

    fn state(&self) -> State {
        self.machine.condition().state
    }

    fn reason(&self) -> Reason {
        self.machine.condition().reason
    }
}

fn host(path: &Path, persistence: Persistence) -> Driver<'_> {
    let place = FollowerPosition::default();
    Driver::new(path.items(place), persistence, 9, Options::default())
}

fn last(path: &Path) -> u32 {
    path.view().knot(KNOTS - 1).unwrap().angles[0].to_bits()
}

#[test]
fn plays_the_same_angles_as_a_host() {
    let path = Path::miura();
    let file = path.file();
    let mut streamed = Desk::new(&file, None);
    let mut host = host(&path, Persistence::None).confirming();
    streamed.run(Some(&mut host), 4000);
    assert!(host.is_done());
    let mut played = Desk::new(&file, None);
    assert_eq!(played.press_flat(), None);
    played.finish();
    // From the first tick of the motion to the last.
    let motions = [streamed, played].map(|desk| {
        let mut motion = desk.commands;
        motion.dedup();
        motion
    });
    assert!(motions[0].len() > 1900, "{}", motions[0].len());
    assert_eq!(motions[0].last(), Some(&last(&path)));
    assert_eq!(motions[0], motions[1]);
}

#[test]
fn a_press_holds_and_the_next_one_resumes() {
    let path = Path::miura();
    let file = path.file();
    let mut desk = Desk::new(&file, None);
    desk.half();
    assert_eq!(desk.press(), None);
    desk.run(None, 500);
    assert_eq!(
        (desk.state(), desk.reason()),
        (State::Holding, Reason::HoldCommand)
    );
    desk.rests();
    assert_eq!(
        (desk.state(), desk.reason()),
        (State::Holding, Reason::HoldCommand)
    );
    assert_eq!(desk.press(), None);
    desk.finish();
    // Neither kind of press starts anything that has ended.
    assert_eq!(desk.press(), Some(PlayRefusal::Done));
    desk.rests();
    assert_eq!(desk.press_flat(), None);
    desk.run(None, 1100);
    let refused = Some(PlayRefusal::Denied(Denial::Jump(0)));
    assert_eq!(
        (desk.player.refused(), desk.state()),
        (refused, State::Ready)
    );
    desk.rests();
}

#[test]
fn a_press_before_the_start_calls_it_off() {
    let path = Path::miura();
    let file = path.file();
    let mut desk = Desk::new(&file, None);
    // While items are taken, and while the start waits for measurements.
    for millis in [5, 300] {
        assert_eq!(desk.press_flat(), None);
        desk.run(None, millis);
        assert_eq!(desk.press(), None);
        desk.run(None, 2000);
        assert_eq!((desk.state(), desk.machine.command()), (State::Ready, None));
    }
    assert_eq!(desk.press_flat(), None);
    desk.finish();
}

#[test]
fn the_way_back_and_the_way_there_take_turns() {
    let (path, mut turns) = (Path::miura(), Vec::new());
    let (there, back) = (path.file(), path.reversed().file());
    let mut desk = Desk::new(&there, Some(&back));
    assert_eq!(desk.press_flat(), None);
    desk.finish();
    for _ in 0..3 {
        turns.push(desk.machine.command().unwrap());
        assert_eq!(desk.press(), None);
        // It goes on from the middle after a reset, in the same direction.
        desk.run(None, 800);
        assert_eq!(desk.state(), State::Running);
        desk.machine.reset();
        desk.player = Player::new(&there, Some(&back)).unwrap();
        desk.rests();
        assert_eq!(desk.press(), None);
        desk.finish();
    }
    turns.push(desk.machine.command().unwrap());
    let top = f32::from_bits(last(&path));
    assert_eq!(turns, [top, 0.0, top, 0.0]);
}

#[test]
fn a_button_does_nothing_while_a_host_is_there() {
    let path = Path::miura();
    let file = path.file();
    let mut desk = Desk::new(&file, None);
    let mut first = host(&path, Persistence::None).confirming();
    desk.run(Some(&mut first), 900);
    for _ in 0..3 {
        desk.player.press();
        desk.run(Some(&mut first), 50);
        assert_eq!(desk.player.refused(), Some(PlayRefusal::Host));
        assert_eq!(
            (desk.state(), desk.reason()),
            (State::Running, Reason::None)
        );
        desk.player.release();
        desk.run(Some(&mut first), 50);
        assert_eq!(desk.player.refused(), Some(PlayRefusal::Host));
    }
    // The host falls silent. A second later the button takes up the path where it is.
    desk.run(None, 900);
    assert_eq!(
        (desk.state(), desk.reason()),
        (State::Holding, Reason::Silence)
    );
    assert_eq!(desk.press(), Some(PlayRefusal::Host));
    desk.run(None, 200);
    let stood = desk.machine.command().unwrap();
    assert!(stood > 0.3, "{stood}");
    assert_eq!(desk.press(), None);
    desk.run(None, 500);
    assert_eq!(desk.state(), State::Running);
    assert!(desk.machine.command().unwrap() > stood);
    // Another host takes the motion over: it holds, and goes on only as the host says.
    let mut second = host(&path, Persistence::Resume);
    desk.run(Some(&mut second), 4000);
    assert!(second.is_done());
    assert!(!desk.player.is_playing());
    assert_eq!(desk.machine.command().map(f32::to_bits), Some(last(&path)));
}

/// An operator has asked to hold, and has gone to the sheet: a press of somebody else does not move it.
#[test]
fn a_hold_of_a_host_is_undone_by_release_and_by_no_press() {
    let path = Path::miura();
    let file = path.file();
    let mut desk = Desk::new(&file, None);
    let mut operator = host(&path, Persistence::None).confirming();
    desk.run(Some(&mut operator), 900);
    operator.stop();
    desk.run(Some(&mut operator), 500);
    desk.run(None, 1100);
    for _ in 0..2 {
        let held = Some(PlayRefusal::Denied(Denial::Held));
        assert_eq!([desk.press(), desk.press_flat()], [held; 2]);
        assert_eq!(
            (desk.state(), desk.reason()),
            (State::Holding, Reason::HoldCommand)
        );
        desk.rests();
    }
    assert_eq!(desk.release(), None);
    desk.rests();
    assert_eq!(desk.press(), None);
    desk.finish();
    assert_eq!(desk.machine.command().map(f32::to_bits), Some(last(&path)));
}

/// Frames of a session that a button has ended do nothing: their host learns that it is over, and the path is played on.
#[test]
fn a_host_that_wakes_up_adds_nothing_to_the_path() {
    let path = Path::miura();
    let file = path.file();
    let mut desk = Desk::new(&file, None);
    let mut sleeper = host(&path, Persistence::None).confirming();
    desk.run(Some(&mut sleeper), 600);
    desk.run(None, 1500);
    assert_eq!(desk.press(), None);
    desk.run(None, 300);
    desk.run(Some(&mut sleeper), 300);
    assert_eq!(sleeper.sender().phase(), Phase::Failed(Failure::Lost));
    assert_eq!(desk.reason(), Reason::None);
    assert!(desk.player.is_playing());
    desk.finish();
    assert_eq!(desk.machine.command().map(f32::to_bits), Some(last(&path)));
}

#[test]
fn a_stop_line_holds_against_each_press() {
    let path = Path::miura();
    let file = path.file();
    let mut desk = Desk::new(&file, None);
    desk.half();
    desk.machine.bench(|bench| bench.stop = true);
    desk.run(None, 1);
    let held = Some(PlayRefusal::Denied(Denial::Held));
    for drawn in [true, false] {
        desk.machine.bench(|bench| bench.stop = drawn);
        for _ in 0..2 {
            assert_eq!(desk.press(), held);
            assert_eq!(desk.press_flat(), held);
            desk.rests();
        }
        if drawn {
            assert_eq!(desk.release(), held);
            desk.rests();
        }
    }
    // It lasts over a reset, and the release moves nothing.
    desk.machine.reset();
    desk.run(None, 10);
    assert_eq!(desk.press(), held);
    assert_eq!(desk.release(), None);
    desk.rests();
    assert_eq!(desk.state(), State::Idle);
    assert_eq!(desk.press(), None);
    desk.finish();
}

#[test]
fn a_fault_holds_against_each_press() {
    let path = Path::miura();
    let file = path.file();
    let mut desk = Desk::new(&file, None);
    desk.machine.bench(|bench| bench.sensor = Some(EXACT));
    desk.half();
    // A blocked hinge: it is measured where it was flat.
    desk.machine.bench(|bench| {
        bench.sensor = Some(|hinge, _, stands| if hinge == 4 { 0.0 } else { stands })
    });
    desk.run(None, 2500);
    let fault = Fault::Stalled(4);
    assert_eq!(
        (desk.state(), desk.reason()),
        (State::Faulted, Reason::Fault(fault))
    );
    assert_eq!(desk.player.refused(), Some(PlayRefusal::Fault(fault)));
    assert_eq!(desk.press(), Some(PlayRefusal::Fault(fault)));
    assert_eq!(desk.press_flat(), Some(PlayRefusal::Fault(fault)));
    desk.rests();
    assert_eq!(desk.release(), None);
    desk.rests();
    desk.machine.bench(|bench| bench.sensor = Some(EXACT));
    assert_eq!(desk.press(), None);
    desk.finish();
}

#[test]
fn after_a_loss_of_power_nothing_moves_from_an_unknown_place() {
    let path = Path::miura();
    let file = path.file();
    let denied = |denial| Some(PlayRefusal::Denied(denial));
    for moment in 0..8 {
        let mut desk = Desk::new(&file, None);
        assert_eq!(desk.press_flat(), None);
        desk.run(None, 1600 + 150 * moment);
        assert!(desk.machine.command().unwrap() > 0.11);
        desk.machine.cut_power(moment + 2);
        desk.player = Player::new(&file, None).unwrap();
        desk.rests();
        // Nobody knows the place.
        assert_eq!(desk.press(), None);
        desk.rests();
        assert_eq!(desk.player.refused(), denied(Denial::Unknown(0)));
        // The sensors know that it is not the beginning, whatever the operator says.
        desk.machine.bench(|bench| bench.sensor = Some(EXACT));
        for flat in [false, true] {
            let refused = if flat {
                desk.press_flat()
            } else {
                desk.press()
            };
            assert_eq!(refused, None);
            desk.rests();
            assert_eq!(desk.player.refused(), denied(Denial::Jump(0)));
            assert_eq!(desk.machine.command(), None);
        }
        // Somebody opens the sheet.
        desk.machine.bench(|bench| bench.stands.fill(0.01));
        assert_eq!(desk.press(), None);
        desk.run(None, 1100);
        assert!(desk.machine.command().is_some());
        desk.finish();
    }
}

/// The record has kept the place, but the drives have let go of the hinges.
#[test]
fn after_a_reset_with_limp_drives_the_place_is_measured() {
    let path = Path::miura();
    let file = path.file();
    let mut desk = Desk::new(&file, None);
    desk.half();
    desk.machine.bench(|bench| bench.limp = true);
    desk.machine.reset();
    desk.player = Player::new(&file, None).unwrap();
    assert_eq!(desk.press(), None);
    desk.rests();
    let unknown = PlayRefusal::Denied(Denial::Unknown(0));
    assert_eq!(desk.player.refused(), Some(unknown));
    desk.machine.bench(|bench| bench.sensor = Some(EXACT));
    assert_eq!(desk.press(), None);
    desk.finish();
}

#[test]
fn bytes_that_are_no_path_make_no_player() {
    let mut file = Path::miura().file();
    let error = |bytes: &[u8]| Player::new(bytes, None).unwrap_err();
    assert_eq!(error(b""), PlayerError::File(FileError::Truncated(0)));
    let back = file.clone();
    file[100] ^= 1;
    let broken = PlayerError::File(FileError::Checksum);
    assert_eq!(error(&file), broken);
    assert_eq!(
        broken.to_string(),
        "the checksum is not that of the bytes before it"
    );
    assert_eq!(Player::new(&back, Some(&file)).unwrap_err(), broken);
}

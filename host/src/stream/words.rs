//! Describes the reasons, denials and failures of a controller in sentences.

use foldpath_core::follower::{Denial, Fault, Reason};
use foldpath_core::wire::message::{Capacity, ItemRefusal, SCHEMA, VERSION};
use foldpath_core::wire::sender::Failure;

/// Explains why a motion does not run.
pub(super) fn reason(reason: Reason) -> String {
    match reason {
        Reason::None => "nothing holds the motion".into(),
        Reason::Asked => "a host has asked to hold".into(),
        Reason::Underrun => "the queue ran dry".into(),
        Reason::Silence => "the controller did not hear its host for a while".into(),
        Reason::Lag(hinge) => format!("hinge {hinge} lags"),
        Reason::StopLine => {
            "the stop line was drawn; --resume goes on once it is let go".to_string()
        }
        Reason::Session => "the sheet moved for another host when this one came".into(),
        Reason::Refused(refusal) => format!("a setpoint was refused: {refusal}"),
        Reason::Fault(Fault::Stalled(hinge)) => {
            format!("hinge {hinge} has stalled; --resume goes on once it is free")
        }
        Reason::Fault(Fault::Leap(group)) => format!(
            "group {group} would have moved farther in a tick than it may; --resume goes on from where it stands"
        ),
        Reason::Approach => "the groups approach the beginning of the path".into(),
        Reason::Lease => "the path time has reached its bound".into(),
    }
}

/// Explains why a motion holds, and how to go on.
pub(super) fn held(why: Reason) -> String {
    let on = match why {
        Reason::Silence => {
            "; --resume goes on from where the sheet stands, and with --unattended also after the next silence"
        }
        // Its words say so themselves.
        Reason::StopLine => "",
        _ => "; --resume goes on from where the sheet stands",
    };
    reason(why) + on
}

/// Explains why a motion has failed, and that the stop line holds it as well if it is `stopped`.
pub(super) fn failed(why: Reason, stopped: bool) -> String {
    let stop = if stopped {
        ". The stop line holds the motion as well and has to be let go"
    } else {
        ""
    };
    reason(why) + stop
}

/// Explains why a command is not carried out.
pub(super) fn denial(denial: Denial) -> String {
    match denial {
        Denial::State => "the controller cannot do that in its state".into(),
        Denial::Moving => "the sheet still moves".into(),
        Denial::Groups => "the controller has another number of crease groups".into(),
        Denial::Empty => "no setpoint is queued".into(),
        Denial::Place => "the sheet does not stand on the first segment that was sent".into(),
        Denial::Jump(group) => format!(
            "group {group} stands elsewhere than the path begins; --resume begins where it stands"
        ),
        Denial::Held => "something holds the motion".into(),
        Denial::Unknown(group) => format!(
            "the controller does not know where group {group} stands, and measures none of its hinges; --at flat, \
             --at goal or --at start says where the sheet stands"
        ),
        Denial::Spread(group) => format!(
            "the hinges of group {group} are measured at different angles; --at flat, --at goal or --at start says where \
             the sheet stands"
        ),
        Denial::Range => {
            "the angle is beyond the limits of the controller's board for this hinge".into()
        }
    }
}

/// Explains why an item of the path was refused; `knot` is the number of the knot that the controller expected next, and
/// `room` is that of the controller.
pub(super) fn refusal(refusal: ItemRefusal, knot: u64, room: Option<Capacity>) -> String {
    match refusal {
        ItemRefusal::Setpoint(refusal) => format!("knot {knot} was refused: {refusal}"),
        ItemRefusal::Path(why) => format!("the path was refused: {}", denial(why)),
        ItemRefusal::Room => {
            let Capacity {
                groups,
                hinges,
                spokes,
                ..
            } = room.unwrap_or_default();
            format!(
                "the sheet was refused: the controller has room for {groups} groups, {hinges} hinges and {spokes} spokes"
            )
        }
        ItemRefusal::Pieces | ItemRefusal::Incomplete => {
            "the sheet was refused: its pieces do not fit together".into()
        }
        ItemRefusal::Limits(group) => {
            format!(
                "the limits of group {group} were refused: the board's own limits leave nothing of them"
            )
        }
        ItemRefusal::Hinge(hinge) => format!("hinge {hinge} was refused: it has no group"),
        ItemRefusal::Stars => {
            "the essential vertices were refused: they are not sound, or there is none".into()
        }
        ItemRefusal::Closure => {
            "the sheet was refused: its path is open by more than the controller allows".into()
        }
    }
}

/// Explains why there is no session with a controller that has answered before if it was `met`.
pub(super) fn failure(failure: Failure, met: bool) -> String {
    match failure {
        Failure::Version { version, schema } => format!(
            "the controller speaks version {version} ({schema:08x}) of the protocol, \
             expected {VERSION} ({SCHEMA:08x})"
        ),
        Failure::Lost => "the session is lost: the controller was reset, or another host came; \
                          --resume goes on from where the sheet stands"
            .into(),
        Failure::Silent if met => "the controller is silent".into(),
        Failure::Silent => "no controller answers; one with a key answers only to --key FILE with the same key, and one \
                            without a key only without --key"
            .into(),
    }
}

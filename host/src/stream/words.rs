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
        Reason::Fault(fault) => {
            let on = match fault {
                Fault::Stalled(_) => "once it is free",
                Fault::Leap(_) => "from where it stands",
            };
            format!("{fault}; --resume goes on {on}")
        }
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
    let on = match denial {
        Denial::Jump(_) => "; --resume begins where it stands",
        Denial::Unknown(_) | Denial::Spread(_) => {
            "; --at flat, --at goal or --at start says where the sheet stands"
        }
        _ => "",
    };
    format!("{denial}{on}")
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
        refusal => refusal.to_string(),
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

//! Runs `foldpath loads`, which tells how strong the drives of a sheet have to be.

use std::path::Path;
use std::time::Instant;

use crate::args::{LoadArgs, Loads as Args, Report, Torques};
use crate::progress::watched;
use crate::report::{out_of_time, outcome};
use crate::standard::{Input, source};
use crate::{Answer, CliError, print, print_json, print_notes};
use foldpath::Vector3;
use foldpath::motion::Motion;
use foldpath::pattern::{EdgeId, FaceId};
use foldpath::progress::Watch;
use foldpath::read::check_unit;
use foldpath::request::{LoadsJson, ReadingRequest, Request};
use foldpath::sensitivity::{Load, Loads, NoLoads, STANDARD_GRAVITY};

/// Gives a motion the unit that is named.
///
/// # Errors
/// If the file of this name has another unit, or an option is one of drawings.
pub(crate) fn measured(
    reading: &ReadingRequest,
    name: &Path,
    motion: &mut Motion,
) -> Result<(), CliError> {
    let without_unit = ReadingRequest {
        unit: None,
        ..reading.clone()
    };
    if without_unit != ReadingRequest::default() {
        return Err(CliError::Usage(format!(
            "--tolerance, --straighten, --colors, --layers and --dashes: expected a drawing, found the path {}",
            source(name)
        )));
    }
    if let Some(unit) = reading.options()?.unit {
        check_unit(Path::new(&*source(name)), motion.pattern.unit(), unit)?;
        motion.measured_in(unit);
    }
    Ok(())
}

/// Returns the torques that are to be drawn for a motion of this name; `None` if nobody asks.
///
/// # Errors
/// If there are none.
pub(crate) fn torques(
    args: &Torques,
    name: &Path,
    motion: &Motion,
    quiet: bool,
) -> Result<Option<Loads>, CliError> {
    let Some(density) = args.areal_density else {
        return Ok(None);
    };
    let load = load(&args.load, density);
    let found = watched(&Report { json: false }, quiet, |progress| {
        Loads::least(motion, &load, Watch::new(progress))
    });
    found.map(Some).map_err(|no| refused(name, no))
}

/// Makes the error that a path of this name has no loads.
fn refused(name: &Path, no: NoLoads) -> CliError {
    let hint = match no {
        NoLoads::NoUnit => ": `--unit mm` tells it",
        _ => "",
    };
    CliError::Usage(format!("{}: {no}{hint}", source(name)))
}

/// Returns the load of a sheet.
fn load(args: &LoadArgs, areal_density: f64) -> Load {
    Load {
        areal_density,
        fixed: args.fixed.map(FaceId),
        gravity: args
            .gravity
            .map_or(Vector3::new(0.0, 0.0, -STANDARD_GRAVITY), |it| it.0),
        spring: args
            .spring
            .iter()
            .rfind(|spring| spring.edge.is_none())
            .map_or(0.0, |spring| spring.stiffness),
        springs: args
            .spring
            .iter()
            .filter_map(|spring| Some((EdgeId(spring.edge?), spring.stiffness)))
            .collect(),
    }
}

pub(crate) fn run(args: &Args, quiet: bool) -> Answer {
    let deadline = args.until.deadline()?;
    let mut motion = Input::of(&args.path)?.motion_for("loads")?;
    measured(args.load.reading.get()?, &args.path, &mut motion)?;
    let load = load(&args.load, args.areal_density);
    let drives = match &args.drives {
        Some(file) => Input::of(file)?.drives()?,
        None => Vec::new(),
    };
    let loads = watched(&args.report, quiet, |progress| {
        let watch = Watch::new(progress).until(deadline);
        Loads::least_of(&motion, &load, args.drivers, watch)
    });
    let loads = match loads {
        Err(no @ NoLoads::Cancelled) => return out_of_time(&args.path, no, &args.report),
        loads => loads.map_err(|no| refused(&args.path, no))?,
    };
    let is_up = deadline.is_some_and(|deadline| Instant::now() >= deadline);
    let json = LoadsJson::of(&motion, &loads, &drives);
    let fits = json.fits.iter().all(|fit| fit.fits);
    if args.report.json {
        print_json(&json)?;
        return Ok(fits);
    }
    print_notes(quiet, motion.pattern.assumptions());
    let named: Vec<String> = json.drivers.iter().map(ToString::to_string).collect();
    let least = match loads.is_least {
        _ if is_up => "time ran out in the search for a better set",
        true => "of all sets the one whose largest torque is least",
        false => "no exchange of one driver makes the largest torque less",
    };
    let mut text = format!(
        "{}: {:.4e} Nm at hinge {}, at {:.3} s\n  \
         drivers  hinges {}: {least}; regularity at least {:.1e}\n",
        motion.title,
        json.peak.torque,
        json.peak.driver,
        json.peak.at,
        named.join(", "),
        json.regularity,
    );
    if loads.left_out > 0 {
        text += &format!(
            "  {} of {} times are left out, at which the sheet is singular\n",
            loads.left_out,
            loads.left_out + loads.times.len()
        );
    }
    for fit in &json.fits {
        let told = match fit.at {
            None => outcome(true, "fits"),
            Some(at) => format!("{} at {at:.3} s", outcome(false, "stalls")),
        };
        text += &format!("  {}: {told}\n", fit.drive);
    }
    text += "  time, torque of each driver in Nm\n";
    for (time, torques) in json.times.iter().zip(&json.torques) {
        let torques: Vec<String> = torques
            .iter()
            .map(|torque| format!("{torque:>12.4e}"))
            .collect();
        text += &format!("    {time:>9.3}  {}\n", torques.join("  "));
    }
    print(&text)?;
    Ok(fits)
}

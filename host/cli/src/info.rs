//! Runs `foldpath info`, which describes a crease pattern.

use crate::args::Info;
use crate::report::lost_lines;
use crate::standard::Input;
use crate::{Answer, foldability, print, print_json, print_notes};
use foldpath::folding::DEFAULT_BOUND;
use foldpath::planner::CLOSED;
use foldpath::progress::Watch;
use foldpath::read::fold::PatternFile;
use foldpath::request::{EdgeInfo, EdgesInfo, PatternInfo, Request, radians_hint};

pub(crate) fn run(args: &Info, quiet: bool) -> Answer {
    let deadline = args.until.deadline()?;
    let watch = Watch::default().until(deadline);
    let options = args.reading.get()?.options()?;
    let input = Input::of(&args.pattern)?;
    let file = input.pattern(&input.bytes()?, &options)?;
    let motion = input.motion_of_sheet();
    drop(input);
    let pattern = &file.pattern;
    let mut info = PatternInfo::of(pattern, watch);
    motion.iter().for_each(|motion| info.moved_by(motion));
    if args.edges {
        info.edges = EdgesInfo::list(pattern);
    }
    if args.report.json {
        print_json(&info)?;
        return Ok(true);
    }
    print_notes(quiet, &info.repairs);
    print_notes(quiet, &info.assumptions);
    print_notes(quiet, radians_hint(pattern, info.closure_goal).as_slice());
    let mut text = summary(&file, &info, motion.is_some());
    text += &foldability::text(pattern, &info.crease_groups, &info.forecast, &args.pattern);
    if let EdgesInfo::List(edges) = &info.edges {
        text += &listed(edges);
    }
    print(&text)?;
    Ok(true)
}

/// Returns a row for each edge.
fn listed(edges: &[EdgeInfo]) -> String {
    let mut text = "\nedges: letter, goal in degrees, ends, names\n".to_string();
    for edge in edges {
        let goal = edge
            .goal
            .map_or_else(|| "-".into(), |goal| format!("{goal:.6}"));
        let [from, to] = edge.ends.map(|[x, y]| format!("({x}, {y})"));
        let row = format!(
            "  {:>5}  {}  {goal:>11}  {from} to {to}",
            edge.edge, edge.letter
        );
        text += &row;
        if !edge.names.is_empty() {
            text += &format!("  {}", edge.names.join(", "));
        }
        text.push('\n');
    }
    text
}

fn summary(file: &PatternFile, info: &PatternInfo, moves: bool) -> String {
    let letters = info
        .letters
        .iter()
        .map(|(code, count)| format!("{count} {code}"));
    let letters = letters.collect::<Vec<_>>().join(", ");
    let goal = match info.closure_goal {
        None if info.letters.keys().any(|code| "MV".contains(*code)) => {
            let hinges = file.pattern.creases().iter();
            let mut goals = hinges.map(|&edge| file.pattern.edge(edge).goal);
            match goals.any(|goal| goal.is_some()) {
                true => "not for every crease: plan folds to what is named",
                false => "no angles: plan folds along the letters",
            }
            .to_string()
        }
        None => "none, and no letters that say a way".to_string(),
        Some(closure) if closure <= CLOSED => format!("closes (residual {closure:.1e})"),
        Some(closure) => format!("does not close (residual {closure:.1e})"),
    };
    let count =
        |count: usize, one: &str| format!(", {count} {one}{}", if count > 1 { "s" } else { "" });
    let mut parts = String::new();
    if info.sheets > 1 {
        parts += &count(info.sheets, "sheet");
    }
    let holes = file.pattern.holes().len();
    if holes > 0 {
        parts += &count(holes, "hole");
    }
    if let Some(unit) = file.pattern.unit() {
        parts += &format!(", lengths in {}", unit.name());
    }
    let lost = file.pattern.lost_lines().map(lost_lines);
    let lost = lost.map_or_else(String::new, |lost| {
        format!("  lost lines          {lost}\n")
    });
    let amplification = info.amplification.map_or_else(
        || "unknown".to_string(),
        |factor| format!("{factor:.4}: errors of the sheet per closure residual of a vertex"),
    );
    let skew = info.skew_bound.map_or_else(
        || "unknown".to_string(),
        |skew| {
            let speed = match moves {
                true => "along this path",
                false => "at 45 degrees a second",
            };
            format!("boards may be {skew:.1e} s apart {speed}: gaps stay within {DEFAULT_BOUND}")
        },
    );
    format!(
        "{}\n{lost}  \
         sheet               {} faces, {} vertices ({} real, {} virtual), {} edges ({letters}){parts}\n  \
         hinges              {} creases, {} of them free; {} virtual edges stay flat\n  \
         crease groups       {}\n  \
         essential vertices  {}\n  \
         controller          needs room for {} groups, {} hinges and {} spokes\n  \
         amplification       {amplification}\n  \
         skew                {skew}\n  \
         goal                {goal}\n",
        file.title,
        info.faces,
        info.vertices,
        info.real_vertices,
        info.virtual_vertices,
        file.pattern.edges().len(),
        info.creases,
        info.free_hinges,
        info.virtual_edges,
        info.groups,
        info.essential_vertices,
        info.groups,
        info.creases,
        info.spokes,
    )
}

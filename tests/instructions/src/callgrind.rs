//! Runs one kernel of this program under callgrind and reads its instruction count.

use std::process::{Command, Stdio};

use crate::kernels::Kernel;

/// Pattern for the symbol of the function inside which instructions are counted.
const COUNTED: &str = "*kernels::counted*";

/// Returns the number of instructions of one call of the kernel.
pub(crate) fn count(kernel: &Kernel) -> Result<f64, String> {
    eprintln!("counting {}", kernel.name);
    let out = tempfile::NamedTempFile::new().map_err(|error| error.to_string())?;
    let program = std::env::current_exe().map_err(|error| error.to_string())?;
    let result = Command::new("valgrind")
        .args(["--tool=callgrind", "--collect-atstart=no"])
        .arg(format!("--toggle-collect={COUNTED}"))
        .arg(format!("--callgrind-out-file={}", out.path().display()))
        .arg(program)
        .args(["--only-run", kernel.name])
        .stdin(Stdio::null())
        .output()
        .map_err(|error| format!("valgrind: {error}; install it, as tests/run does"))?;
    if !result.status.success() {
        return Err(format!(
            "{} under valgrind: {}\n{}",
            kernel.name,
            result.status,
            String::from_utf8_lossy(&result.stderr)
        ));
    }
    let text = std::fs::read_to_string(out.path()).map_err(|error| error.to_string())?;
    let total = text.lines().find_map(|line| line.strip_prefix("totals: "));
    let total = total.and_then(|total| total.trim().parse::<u32>().ok());
    match total {
        Some(total) if total > 0 => Ok(f64::from(total) / f64::from(kernel.calls)),
        _ => Err(format!("{}: callgrind counted nothing", kernel.name)),
    }
}

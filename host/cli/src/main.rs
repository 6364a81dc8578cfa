//! Starts the command `foldpath`.

fn main() -> std::process::ExitCode {
    foldpath_cli::main()
}

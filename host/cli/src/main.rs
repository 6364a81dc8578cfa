//! The `foldpath` command.

fn main() -> std::process::ExitCode {
    foldpath_cli::main()
}

//! The `foldpath` command.

fn main() -> std::process::ExitCode {
    foldpath::cli::main()
}

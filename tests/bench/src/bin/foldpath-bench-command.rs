//! The `foldpath` command, which the benchmarks start as a user does.

fn main() -> std::process::ExitCode {
    foldpath_cli::main()
}

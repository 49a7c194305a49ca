//! The `clerestory` program: everything happens in the library.

use std::process::ExitCode;

fn main() -> ExitCode {
    clerestory::cli::run()
}

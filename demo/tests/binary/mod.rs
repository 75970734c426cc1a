//! Running the built binary.
#![allow(dead_code, reason = "each test binary uses its part")]

use std::process::{Command, Output};

pub fn command(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_quell-demo"));
    command.args(arguments);
    command
}

pub fn demo(arguments: &[&str]) -> Output {
    command(arguments).output().unwrap()
}

/// The binary must succeed; returns what it printed.
pub fn assert_succeeds(output: &Output) -> String {
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8_lossy(&output.stdout).into_owned()
}

/// The binary must fail with `code` and say all of `parts` on stderr.
pub fn assert_fails(output: &Output, code: i32, parts: &[&str]) {
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(code), "{message}");
    assert!(output.stdout.is_empty());
    assert!(!message.contains("panicked"), "{message}");
    for part in parts {
        assert!(message.contains(part), "`{part}` is not in: {message}");
    }
}

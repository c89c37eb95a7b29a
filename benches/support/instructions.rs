//! Instructions, which do not depend on what else the machine does.

use std::process::Command;

/// How many instructions this program takes when it is run with `arguments`, as
/// counted by valgrind; `None` where that is not installed.
pub fn instructions(arguments: &[&str]) -> Option<f64> {
    let output = Command::new("valgrind")
        .args(["--tool=callgrind", "--callgrind-out-file=/dev/null"])
        .arg(std::env::current_exe().ok()?)
        .args(arguments)
        .output()
        .ok()?;
    let report = String::from_utf8(output.stderr).ok()?;
    let (_, total) = report
        .lines()
        .find_map(|line| line.split_once("Collected : "))?;
    total.trim().parse().ok()
}

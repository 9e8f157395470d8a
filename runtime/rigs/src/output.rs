//! Standard output of the command line and parsing of counts.

use std::path::Path;

use clap::Args;
use indicatif::ProgressBar;
use serde::Serialize;

use sheetwork::InputError;

/// Prints a JSON value as the only content of standard output.
pub fn print_json(value: &impl Serialize) -> Result<(), InputError> {
    let text = serde_json::to_string_pretty(value).map_err(|e| InputError::new("", e.to_string()))?;
    print_line(&text)
}

/// Prints a line. A closed reader (`| head`) is not an error.
pub fn print_line(text: &str) -> Result<(), InputError> {
    use std::io::Write;
    match writeln!(std::io::stdout(), "{text}") {
        Err(e) if e.kind() != std::io::ErrorKind::BrokenPipe => Err(InputError::new("standard output", e.to_string())),
        _ => Ok(()),
    }
}

/// Executes the command that a variant of an enum holds.
#[macro_export]
macro_rules! execute {
    ($command:expr, $commands:ident: $($name:ident),*) => {
        match $command {
            $($commands::$name(command) => command.execute(),)*
        }
    };
}

/// Form of the output.
#[derive(Args, Clone, Copy)]
pub struct OutputFlags {
    /// Print JSON and nothing else.
    #[arg(long)]
    pub json: bool,
}

impl OutputFlags {
    /// Prints a result as JSON, or as a line of text.
    pub fn print<T: Serialize>(
        self,
        json: impl FnOnce() -> T,
        text: impl FnOnce() -> String,
    ) -> Result<(), InputError> {
        if self.json { print_json(&json()) } else { print_line(&text()) }
    }

    /// A progress bar of `count` steps, hidden with JSON.
    pub fn bar(self, count: u64) -> ProgressBar {
        if self.json { ProgressBar::hidden() } else { ProgressBar::new(count) }
    }
}

/// Parses whole numbers separated by `x`, as in `11x2x11`.
pub fn parse_counts<const N: usize>(text: &str) -> Result<[u32; N], String> {
    let parts: Result<Vec<u32>, _> = text.split(['x', 'X']).map(|p| p.trim().parse::<u32>()).collect();
    parts
        .ok()
        .and_then(|p| <[u32; N]>::try_from(p).ok())
        .ok_or_else(|| format!("\"{text}\" is not {N} whole numbers joined by x"))
}
/// Checks that `file` can be written: its folder exists and it is not itself a folder.
pub fn check_writable(file: &Path) -> Result<(), InputError> {
    let folder = file.parent().filter(|folder| !folder.as_os_str().is_empty());
    match folder {
        _ if file.is_dir() => Err(InputError::new("", "is a folder").in_file(file)),
        Some(folder) if !folder.is_dir() => Err(InputError::new("", "its folder does not exist").in_file(file)),
        _ => Ok(()),
    }
}

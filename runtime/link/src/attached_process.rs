//! Attached processes, by number and name.

use std::path::Path;

/// A process that is attached to a game.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AttachedProcess {
    /// Process number.
    pub process: u32,
    /// Program and first argument: "sheetwork watch", "python3 tip_height.py". Empty on systems
    /// that do not report it.
    pub name: String,
    /// Number of subscriptions to streams: frames, fields, topology, events.
    pub reads: usize,
    /// Whether it may send commands.
    pub commands: bool,
}

impl AttachedProcess {
    /// Counts one more port of `process`, for reading or for commands.
    pub(crate) fn count(list: &mut Vec<Self>, process: u32, commands: bool) {
        let at = list.iter().position(|a| a.process == process).unwrap_or_else(|| {
            list.push(Self { process, name: name_of(process), reads: 0, commands: false });
            list.len() - 1
        });
        let one = &mut list[at];
        one.reads += usize::from(!commands);
        one.commands |= commands;
    }
}

impl std::fmt::Display for AttachedProcess {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if self.name.is_empty() { write!(f, "{}", self.process) } else { write!(f, "{} ({})", self.name, self.process) }
    }
}

/// Program of a process, and its first argument that is not a flag.
fn name_of(process: u32) -> String {
    let line = std::fs::read(format!("/proc/{process}/cmdline")).unwrap_or_default();
    let line = String::from_utf8_lossy(&line);
    let mut words = line.split('\0').filter(|w| !w.is_empty());
    let file = |word: &str| Path::new(word).file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
    let Some(program) = words.next().map(file) else { return String::new() };
    let short = |word: String| word.chars().take(40).collect::<String>();
    match words.next().filter(|w| !w.starts_with('-')) {
        Some(word) => format!("{} {}", short(program), short(file(word))),
        None => short(program),
    }
}

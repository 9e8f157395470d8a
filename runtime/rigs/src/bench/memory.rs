//! Memory of this process as the system reports it.

/// Growth that is tolerated, bytes: pages that the allocator had not touched before.
pub const MEMORY_GROWTH_TOLERANCE: u64 = 256 << 10;

/// Present private memory of this process, bytes; 0 on systems that do not report it.
pub fn process_memory() -> u64 {
    let text = std::fs::read_to_string("/proc/self/smaps_rollup").unwrap_or_default();
    let line = text.lines().find(|l| l.starts_with("Pss_Anon:")).unwrap_or_default();
    line.split_whitespace().nth(1).and_then(|kb| kb.parse::<u64>().ok()).unwrap_or(0) * 1024
}

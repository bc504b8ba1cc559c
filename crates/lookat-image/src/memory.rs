//! The memory budget of reading, rendering and comparing.

use std::fs::read_to_string;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use sysinfo::{MemoryRefreshKind, RefreshKind, System};

/// A limit on memory, and the bytes charged against it. Clones share one account.
///
/// Reserve memory before allocating an array whose size comes from a file. The default is
/// [`MemoryBudget::machine_limit`].
#[derive(Debug, Clone)]
pub struct MemoryBudget {
    limit: u64,
    account: Arc<Account>,
}

/// Bytes charged now, and the most so far.
#[derive(Debug, Default)]
struct Account {
    used: AtomicU64,
    most: AtomicU64,
}

/// Memory of a budget. Dropping it returns the bytes.
#[derive(Debug)]
#[must_use = "dropping a charge returns its bytes"]
pub struct Charge {
    bytes: u64,
    budget: MemoryBudget,
}

/// A request for more memory than the budget has left.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("{}", self.words())]
pub struct OutOfMemory {
    /// The requested bytes.
    pub needed: u64,
    /// The bytes charged before.
    pub used: u64,
    /// The bytes that the budget allows in total.
    pub limit: u64,
}

impl OutOfMemory {
    fn words(&self) -> String {
        let [needed, used, limit] = [self.needed, self.used, self.limit].map(byte_words);
        let used = if self.used > 0 { format!(", of which {used} are used") } else { String::new() };
        format!("{needed} of memory are needed, and the limit is {limit}{used}")
    }
}

impl MemoryBudget {
    /// A budget of `limit` bytes.
    pub fn new(limit: u64) -> Self {
        MemoryBudget { limit, account: Arc::default() }
    }

    /// The limit in bytes.
    pub fn limit(&self) -> u64 {
        self.limit
    }

    /// The bytes left.
    pub fn left(&self) -> u64 {
        self.limit.saturating_sub(self.used())
    }

    /// The bytes charged.
    pub fn used(&self) -> u64 {
        self.account.used.load(Ordering::Relaxed)
    }

    /// The most bytes charged at a time so far.
    pub fn most_used(&self) -> u64 {
        self.account.most.load(Ordering::Relaxed)
    }

    /// Charges `bytes` until the charge is dropped. Fails if they do not fit.
    pub fn reserve(&self, bytes: u64) -> Result<Charge, OutOfMemory> {
        let mut charge = Charge { bytes: 0, budget: self.clone() };
        charge.resize(bytes).map(|()| charge)
    }

    /// Three quarters of the machine's memory, or of the smaller limits of the process and its control group. 6 GB if
    /// the system does not report its memory.
    pub fn machine_limit() -> u64 {
        let machine = machine_memory().unwrap_or(8_000_000_000) / 4 * 3;
        machine.min(MemoryBudget::process_limit().unwrap_or(u64::MAX))
    }

    /// Three quarters of the memory that `ulimit -v`, `ulimit -d` and the control groups leave; the rest is for the
    /// program itself. `None` without a limit.
    pub fn process_limit() -> Option<u64> {
        [process_limit(), group_limit()].into_iter().flatten().min().map(|limit| limit / 4 * 3)
    }
}

impl Charge {
    /// Changes the charged bytes. Fails, and changes nothing, if more do not fit.
    pub fn resize(&mut self, bytes: u64) -> Result<(), OutOfMemory> {
        let limit = self.budget.limit;
        let resized = |used: u64| (used - self.bytes).checked_add(bytes).filter(|sum| *sum <= limit);
        let Account { used, most } = &*self.budget.account;
        match used.fetch_update(Ordering::Relaxed, Ordering::Relaxed, resized) {
            Ok(before) => {
                most.fetch_max(before - self.bytes + bytes, Ordering::Relaxed);
                self.bytes = bytes;
            }
            Err(used) => return Err(OutOfMemory { needed: bytes, used: used - self.bytes, limit }),
        }
        Ok(())
    }

    /// Charges the bytes for good.
    pub fn keep(mut self) {
        self.bytes = 0;
    }
}

impl Drop for Charge {
    fn drop(&mut self) {
        self.budget.account.used.fetch_sub(self.bytes, Ordering::Relaxed);
    }
}

impl Default for MemoryBudget {
    fn default() -> Self {
        MemoryBudget::new(MemoryBudget::machine_limit())
    }
}

/// A size in words: `51.2 kB`, `1.5 GB`. The greatest number stands for any greater size: `more than 18446744073.7 GB`.
pub fn byte_words(bytes: u64) -> String {
    match bytes as f64 {
        _ if bytes == u64::MAX => format!("more than {}", byte_words(bytes - 1)),
        bytes if bytes < 1e5 => format!("{:.1} kB", bytes / 1e3),
        bytes if bytes < 1e9 => format!("{:.1} MB", bytes / 1e6),
        bytes => format!("{:.1} GB", bytes / 1e9),
    }
}

/// The bytes of main memory. `None` on systems that do not report it.
fn machine_memory() -> Option<u64> {
    let memory = MemoryRefreshKind::nothing().with_ram();
    let system = System::new_with_specifics(RefreshKind::nothing().with_memory(memory));
    Some(system.total_memory()).filter(|bytes| *bytes > 0)
}

/// The bytes that the process can still take within `ulimit -v` and `ulimit -d`.
fn process_limit() -> Option<u64> {
    let limits = read_to_string("/proc/self/limits").ok()?;
    let status = read_to_string("/proc/self/status").ok()?;
    let left = |(limit, taken)| {
        let taken_kilobytes = first_number(&status, taken)?;
        Some(first_number(&limits, limit)?.saturating_sub(1024 * taken_kilobytes))
    };
    [("Max address space", "VmSize:"), ("Max data size", "VmData:")].into_iter().filter_map(left).min()
}

/// The number after a name at the start of a line. `None` for `unlimited`.
fn first_number(text: &str, name: &str) -> Option<u64> {
    let line = text.lines().find_map(|line| line.strip_prefix(name))?;
    line.split_whitespace().next()?.parse().ok()
}

/// The smallest limit of the control groups of the process.
fn group_limit() -> Option<u64> {
    let groups = read_to_string("/proc/self/cgroup").ok()?;
    let limits = groups.lines().flat_map(|line| {
        let mut fields = line.splitn(3, ':').skip(1);
        let (controllers, path) = (fields.next().unwrap_or_default(), fields.next().unwrap_or_default());
        let (root, file) = match controllers {
            "" => ("/sys/fs/cgroup", "memory.max"),
            "memory" => ("/sys/fs/cgroup/memory", "memory.limit_in_bytes"),
            _ => return None,
        };
        let of_group = |group: &Path| {
            let limit = read_to_string(Path::new(root).join(group.strip_prefix("/").ok()?).join(file));
            limit.ok()?.trim().parse::<u64>().ok()
        };
        // The limits of parent groups also apply.
        Path::new(path).ancestors().filter_map(of_group).min()
    });
    limits.min()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clones_share_one_account() {
        let budget = MemoryBudget::new(1000);
        let other = budget.clone();
        let mut charge = other.reserve(600).unwrap();
        let fault = |needed, used| OutOfMemory { needed, used, limit: 1000 };
        assert_eq!(budget.reserve(401).unwrap_err(), fault(401, 600));
        assert_eq!(budget.reserve(u64::MAX).unwrap_err(), fault(u64::MAX, 600));
        assert_eq!((charge.resize(1001), budget.left()), (Err(fault(1001, 0)), 400));
        assert_eq!((charge.resize(100), budget.left()), (Ok(()), 900));
        drop(charge);
        budget.reserve(1000).unwrap().keep();
        assert_eq!((other.left(), other.used(), budget.most_used()), (0, 1000, 1000));
        let words = "0.4 kB of memory are needed, and the limit is 1.0 kB, of which 0.6 kB are used";
        assert_eq!(fault(401, 600).to_string(), words);
    }

    #[test]
    fn sizes_are_short() {
        let words = [84, 99_000, 1_600_000, 8_794_000_000].map(byte_words);
        assert_eq!(words, ["0.1 kB", "99.0 kB", "1.6 MB", "8.8 GB"]);
        assert_eq!(byte_words(u64::MAX), "more than 18446744073.7 GB");
    }

    #[test]
    fn the_machine_has_a_limit() {
        let limit = MemoryBudget::machine_limit();
        assert!((1 << 20..1 << 50).contains(&limit), "{limit}");
        assert_eq!(first_number("MemTotal:  100 kB\nMax data size  unlimited bytes", "MemTotal:"), Some(100));
        assert_eq!(first_number("MemTotal:  100 kB\nMax data size  unlimited bytes", "Max data size"), None);
    }
}

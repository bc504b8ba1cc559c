//! The option `--max-memory`.

use clap::Args;
use lookat_image::{MemoryBudget, OutOfMemory};

/// The memory limit of a command.
#[derive(Debug, Clone, Copy, Args)]
pub struct Memory {
    /// Memory limit, such as 2G or 500M [default: three quarters of what the machine and its limits allow]
    #[arg(long, value_name = "SIZE", allow_negative_numbers = true, value_parser = size)]
    pub max_memory: Option<u64>,
}

impl Memory {
    /// The limit in bytes, at most the limit of the process. `None` if not given.
    pub fn limit(self) -> Option<u64> {
        let given = self.max_memory?;
        Some(given.min(MemoryBudget::process_limit().unwrap_or(u64::MAX)))
    }

    /// A new budget.
    pub fn budget(self) -> MemoryBudget {
        self.limit().map_or_else(MemoryBudget::default, MemoryBudget::new)
    }
}

/// The message about a shortage, with the way out.
pub fn way_out(shortage: OutOfMemory) -> String {
    format!("{shortage}; {RAISE}")
}

const RAISE: &str = "raise --max-memory, and ulimit -v if it is lower";

/// The way out of a limit.
pub fn raise_limit(limit: &str) -> String {
    format!("the limit is {limit}: {RAISE}")
}

/// Parses a size in bytes with an optional decimal unit k, M, G or T.
fn size(text: &str) -> Result<u64, String> {
    let text = text.strip_suffix(['B', 'b']).unwrap_or(text);
    let number = text.trim_end_matches(|c: char| c.is_ascii_alphabetic());
    let factor = match text[number.len()..].to_ascii_uppercase().as_str() {
        "" => 1e0,
        "K" => 1e3,
        "M" => 1e6,
        "G" => 1e9,
        "T" => 1e12,
        _ => f64::NAN,
    };
    let bytes = number.parse().map_or(f64::NAN, |number: f64| number * factor);
    match (1e6..=1e18).contains(&bytes) {
        true => Ok(bytes as u64),
        false => Err("expected a size of at least 1M, as in 500M or 2G".into()),
    }
}

#[cfg(test)]
mod tests {
    use super::size;

    #[test]
    fn sizes_have_units() {
        let sizes = ["2G", "500M", "1.5GB", "2000000", "4000k", "1tb"].map(|text| size(text).unwrap());
        assert_eq!(
            sizes,
            [2_000_000_000, 500_000_000, 1_500_000_000, 2_000_000, 4_000_000, 1_000_000_000_000]
        );
        for text in ["", "G", "0", "-1G", "999k", "1MM", "2 G", "1e30", "nan", "inf", "2GBB", "1P"] {
            assert!(size(text).is_err(), "{text}");
        }
    }
}

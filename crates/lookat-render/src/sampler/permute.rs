//! Permutations of the cells of a grid.

/// The image of `i` under a permutation of `0..n` that `seed` chooses (Kensler, "Correlated Multi-Jittered Sampling",
/// 2013).
pub(super) fn permute(mut i: u32, n: u32, seed: u32) -> u32 {
    if n <= 1 {
        return 0;
    }
    let mask = n.next_power_of_two().wrapping_sub(1);
    loop {
        i ^= seed;
        i = i.wrapping_mul(0xe170_893d);
        i ^= seed >> 16;
        i ^= (i & mask) >> 4;
        i ^= seed >> 8;
        i = i.wrapping_mul(0x0929_eb3f);
        i ^= seed >> 23;
        i ^= (i & mask) >> 1;
        i = i.wrapping_mul(1 | seed >> 27);
        i = i.wrapping_mul(0x6935_fa69);
        i ^= (i & mask) >> 11;
        i = i.wrapping_mul(0x74dc_b303);
        i ^= (i & mask) >> 2;
        i = i.wrapping_mul(0x9e50_1cc3);
        i ^= (i & mask) >> 2;
        i = i.wrapping_mul(0xc860_a3df);
        i &= mask;
        i ^= i >> 5;
        if i < n {
            return ((u64::from(i) + u64::from(seed)) % u64::from(n)) as u32;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn permutations_are_permutations() {
        for n in [1, 2, 3, 10, 64, 100] {
            let mut image: Vec<u32> = (0..n).map(|i| permute(i, n, 12345)).collect();
            image.sort_unstable();
            assert_eq!(image, (0..n).collect::<Vec<_>>());
        }
    }
}

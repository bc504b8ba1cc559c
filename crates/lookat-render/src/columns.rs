//! Columns: plain arrays that store records of eight lanes, so that many of them are gathered before the next step takes them together.

use fearless_simd::{Simd, f32x8, f64x8, mask32x8, mask64x8, prelude::*, u32x8};

use crate::number::{LANES, has_compress, narrow, set_lanes, splat_f32, widen};

/// The most records that are gathered.
pub(crate) const MOST: usize = 64;
/// Room for the records, and for eight that are stored at once.
pub(crate) const ROOM: usize = MOST + LANES;

/// The lanes of a record that are stored.
pub(crate) struct Stored<S: Simd> {
    active: mask64x8<S>,
    narrow: mask32x8<S>,
    /// The active lanes, for processors that move them one by one.
    order: [u8; LANES],
}

impl<S: Simd> Stored<S> {
    #[inline(always)]
    pub fn new(active: mask64x8<S>) -> Self {
        let (mut order, mut count) = ([0; LANES], 0);
        if !has_compress(active.token()) {
            for lane in set_lanes(active) {
                order[count] = lane as u8;
                count += 1;
            }
        }
        Stored { active, narrow: narrow(active), order }
    }

    #[inline(always)]
    fn one_by_one<T: Copy>(&self, all: &[T; LANES], to: &mut [T]) {
        for (to, lane) in to.iter_mut().zip(self.order) {
            *to = all[usize::from(lane) % LANES];
        }
    }
}

/// Values of eight lanes, as a column stores them.
pub(crate) trait Column<S: Simd>: Copy {
    type Element;

    /// Loads the first eight values.
    fn load(simd: S, from: &[Self::Element]) -> Self;

    /// Stores the values of the active lanes, one after the other. It may write eight.
    fn store(self, stored: &Stored<S>, to: &mut [Self::Element]);
}

/// Columns of plain numbers. `$lanes`: the mask of the lanes that are stored.
macro_rules! number_columns {
    ($($vector:ident of $element:ty, $compress:ident by $lanes:ident;)*) => {
        $(impl<S: Simd> Column<S> for $vector<S> {
            type Element = $element;

            #[inline(always)]
            fn load(simd: S, from: &[$element]) -> Self {
                $vector::from_slice(simd, from)
            }

            #[inline(always)]
            fn store(self, stored: &Stored<S>, to: &mut [$element]) {
                let simd = self.token();
                if has_compress(simd) {
                    simd.$compress(self, stored.$lanes).store_slice(to);
                } else {
                    stored.one_by_one(&self.to_array(), to);
                }
            }
        })*
    };
}
number_columns! {
    f64x8 of f64, compress_f64x8 by active;
    f32x8 of f32, compress_f32x8 by narrow;
    u32x8 of u32, compress_u32x8 by narrow;
}

/// A mask is stored as 1 and 0.
impl<S: Simd> Column<S> for mask32x8<S> {
    type Element = f32;

    #[inline(always)]
    fn load(simd: S, from: &[f32]) -> Self {
        f32x8::from_slice(simd, from).simd_gt(0.0)
    }

    #[inline(always)]
    fn store(self, stored: &Stored<S>, to: &mut [f32]) {
        let simd = self.token();
        self.select(splat_f32(simd, 1.0), splat_f32(simd, 0.0)).store(stored, to);
    }
}

impl<S: Simd> Column<S> for mask64x8<S> {
    type Element = f32;

    #[inline(always)]
    fn load(simd: S, from: &[f32]) -> Self {
        widen(Column::load(simd, from))
    }

    #[inline(always)]
    fn store(self, stored: &Stored<S>, to: &mut [f32]) {
        narrow(self).store(stored, to);
    }
}

impl<S: Simd> Column<S> for [u16; LANES] {
    type Element = u32;

    #[inline(always)]
    fn load(_: S, from: &[u32]) -> Self {
        std::array::from_fn(|lane| from[lane] as u16)
    }

    #[inline(always)]
    fn store(self, stored: &Stored<S>, to: &mut [u32]) {
        let wide: u32x8<S> = self.map(u32::from).simd_into(stored.active.token());
        wide.store(stored, to);
    }
}

/// A struct of columns, from the only list of what it stores of a record.
macro_rules! columns {
    ($(#[$doc:meta])* $visibility:vis struct $columns:ident of $record:ident {
        $($column:ident: $element:ty = $($field:tt).+ $([$index:literal])?,)*
    }) => {
        $(#[$doc])*
        #[derive(Clone)]
        $visibility struct $columns {
            $(pub $column: [$element; $crate::columns::ROOM],)*
        }

        impl $columns {
            pub fn new() -> Self {
                $columns { $($column: [Default::default(); $crate::columns::ROOM],)* }
            }

            #[allow(dead_code, reason = "some are read one by one")]
            /// Loads the eight values from one on into a record.
            #[inline(always)]
            pub fn load<S: Simd>(&self, simd: S, from: usize, record: &mut $record<S>) {
                $(record.$($field).+ $([$index])? = $crate::columns::Column::load(simd, &self.$column[from..from + LANES]);)*
            }

            /// Stores the active lanes of a record one after the other from a place on, and may write eight.
            #[inline(always)]
            pub fn store<S: Simd>(&mut self, at: usize, stored: &$crate::columns::Stored<S>, record: &$record<S>) {
                $($crate::columns::Column::store(record.$($field).+ $([$index])?, stored, &mut self.$column[at..at + LANES]);)*
            }
        }
    };
}

pub(crate) use columns;

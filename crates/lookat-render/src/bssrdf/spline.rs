//! Cubic splines through values at nodes (Catmull and Rom; PBR 8.6.1).

/// A spline, and the integral over it.
#[derive(Clone)]
pub(super) struct Spline {
    pieces: Vec<Piece>,
}

/// The cubic between two nodes.
#[derive(Clone)]
struct Piece {
    x: f64,
    width: f64,
    /// The integral from the first node to here.
    before: f64,
    /// The coefficients of powers of the share of the width, from 0 up.
    c: [f64; 4],
}

impl Piece {
    /// The piece after node `at`.
    fn new(nodes: &[f64], values: &[f64], at: usize, before: f64) -> Self {
        let (x, width) = (nodes[at], nodes[at + 1] - nodes[at]);
        let slope = |a: usize, b: usize| width * (values[b] - values[a]) / (nodes[b] - nodes[a]);
        let [d0, d1] = [slope(at.saturating_sub(1), at + 1), slope(at, (at + 2).min(nodes.len() - 1))];
        let rise = values[at + 1] - values[at];
        Piece { x, width, before, c: [values[at], d0, 3.0 * rise - 2.0 * d0 - d1, d0 + d1 - 2.0 * rise] }
    }

    fn value(&self, t: f64) -> f64 {
        let [a, b, c, d] = self.c;
        a + t * (b + t * (c + t * d))
    }

    fn slope(&self, t: f64) -> f64 {
        let [_, b, c, d] = self.c;
        b + t * (2.0 * c + t * 3.0 * d)
    }

    /// The integral from its first node, over the width.
    fn integral(&self, t: f64) -> f64 {
        let [a, b, c, d] = self.c;
        t * (a + t * (b / 2.0 + t * (c / 3.0 + t * d / 4.0)))
    }
}

impl Spline {
    /// The spline through values at rising nodes, of which there are at least two.
    pub fn new(nodes: &[f64], values: &[f64]) -> Self {
        let (mut pieces, mut before) = (Vec::with_capacity(nodes.len() - 1), 0.0);
        for at in 0..nodes.len() - 1 {
            let piece = Piece::new(nodes, values, at, before);
            before += piece.width * piece.integral(1.0);
            pieces.push(piece);
        }
        Spline { pieces }
    }

    /// The last piece that begins before `x` by some measure, or the first.
    fn piece(&self, x: f64, measure: impl Fn(&Piece) -> f64) -> &Piece {
        let after = self.pieces.partition_point(|piece| measure(piece) <= x);
        &self.pieces[after.max(1) - 1]
    }

    fn last(&self) -> &Piece {
        &self.pieces[self.pieces.len() - 1]
    }

    /// The last node.
    pub fn end(&self) -> f64 {
        self.last().x + self.last().width
    }

    /// The value at `x`, between the first and the last node.
    pub fn value(&self, x: f64) -> f64 {
        let piece = self.piece(x, |piece| piece.x);
        piece.value((x - piece.x) / piece.width)
    }

    /// The integral from the first to the last node.
    pub fn integral(&self) -> f64 {
        let last = self.last();
        last.before + last.width * last.integral(1.0)
    }

    /// Where the integral from the first node is `sum`, for a spline of positive values.
    pub fn invert_integral(&self, sum: f64) -> f64 {
        let piece = self.piece(sum, |piece| piece.before);
        let share = (sum - piece.before) / piece.width;
        piece.x + piece.width * solve(share, |t| piece.integral(t), |t| piece.value(t))
    }

    /// Where a spline through rising values has a value; else the nearest node.
    pub fn invert(&self, value: f64) -> f64 {
        let (first, last) = (&self.pieces[0], self.last());
        if value >= last.value(1.0) {
            return self.end();
        }
        if value > first.c[0] {
            let piece = self.piece(value, |piece| piece.c[0]);
            return piece.x + piece.width * solve(value, |t| piece.value(t), |t| piece.slope(t));
        }
        first.x
    }
}

/// The weights of four values, from the one before node `at` on, for the value at `x`. Those that are not there have no weight.
pub(super) fn weights(nodes: &[f64], x: f64) -> (usize, [f64; 4]) {
    let at = nodes.partition_point(|node| *node <= x).clamp(1, nodes.len() - 1) - 1;
    let t = (x - nodes[at]) / (nodes[at + 1] - nodes[at]);
    let from = at.saturating_sub(1);
    let near = &nodes[from..(at + 3).min(nodes.len())];
    let weights = std::array::from_fn(|of| {
        // The spline through one value of 1.
        let Some(one) = (at + of).checked_sub(1 + from).filter(|one| *one < near.len()) else { return 0.0 };
        let mut values = [0.0; 4];
        values[one] = 1.0;
        Piece::new(near, &values, at - from, 0.0).value(t)
    });
    (at, weights)
}

/// Where a rising function from 0 to 1 has a value, by Newton's method between bounds.
fn solve(value: f64, of: impl Fn(f64) -> f64, slope: impl Fn(f64) -> f64) -> f64 {
    const STEPS: u32 = 64;
    const ENOUGH: f64 = 1e-9;
    let (mut low, mut high, mut t) = (0.0, 1.0, 0.5);
    for _ in 0..STEPS {
        let off = of(t) - value;
        (low, high) = if off < 0.0 { (t, high) } else { (low, t) };
        let next = t - off / slope(t);
        let next = if next > low && next < high { next } else { 0.5 * (low + high) };
        let is_done = (next - t).abs() < ENOUGH;
        t = next;
        if is_done {
            break;
        }
    }
    t
}

//! Travel times between views.

use crate::Error;

/// Travel times, sensing included.
///
/// Laws: times are positive, `+infinity` where there is no way, never NaN.
pub trait CostModel {
    /// Seconds from the robot's state to a view.
    fn first(&self, view: usize) -> f64;
    /// Seconds from one view to another.
    fn between(&self, from: usize, to: usize) -> f64;
}

impl<C: CostModel + ?Sized> CostModel for &C {
    fn first(&self, view: usize) -> f64 {
        (**self).first(view)
    }
    fn between(&self, from: usize, to: usize) -> f64 {
        (**self).between(from, to)
    }
}

/// Travel times in arrays.
#[derive(Clone, Debug, PartialEq)]
pub struct Times {
    first: Vec<f64>,
    between: Vec<f64>,
}

impl Times {
    /// `first[v]`: from the robot to view v; `between[from * n + to]`, the diagonal is not looked at.
    ///
    /// # Errors
    /// [`Error::TableSize`]; the values are checked where they are used, by [`Task::new`](crate::Task::new).
    pub fn new(first: Vec<f64>, between: Vec<f64>) -> Result<Self, Error> {
        let wanted = first.len() * first.len();
        if between.len() != wanted {
            return Err(Error::TableSize {
                what: "between",
                found: between.len(),
                wanted,
            });
        }
        Ok(Self { first, between })
    }

    /// As [`new`](Self::new), with the promise that every way takes as long as the way back.
    ///
    /// # Errors
    /// [`Error::TableSize`], or [`Error::Asymmetric`] where the promise is broken.
    pub fn symmetric(first: Vec<f64>, between: Vec<f64>) -> Result<Self, Error> {
        let times = Self::new(first, between)?;
        let n = times.first.len();
        for from in 0..n {
            for to in 0..from {
                let (there, back) = (times.between[from * n + to], times.between[to * n + from]);
                if there != back && !(there.is_nan() && back.is_nan()) {
                    return Err(Error::Asymmetric {
                        from,
                        to,
                        there,
                        back,
                    });
                }
            }
        }
        Ok(times)
    }

    /// From the lower triangle row by row: (1,0), (2,0), (2,1), ...; times are symmetric.
    ///
    /// # Errors
    /// [`Error::TableSize`].
    pub fn from_lower(first: Vec<f64>, lower: &[f64]) -> Result<Self, Error> {
        let n = first.len();
        let wanted = n * n.saturating_sub(1) / 2;
        if lower.len() != wanted {
            return Err(Error::TableSize {
                what: "lower triangle",
                found: lower.len(),
                wanted,
            });
        }
        let mut between = vec![f64::INFINITY; n * n];
        for i in 0..n {
            for j in 0..i {
                let t = lower[i * (i - 1) / 2 + j];
                between[i * n + j] = t;
                between[j * n + i] = t;
            }
        }
        Self::new(first, between)
    }

    /// The same views seen from another state of the robot.
    ///
    /// # Errors
    /// [`Error::TableSize`] if `first` has another length.
    pub fn from_state(&self, first: Vec<f64>) -> Result<Self, Error> {
        Self::new(first, self.between.clone())
    }
}

impl CostModel for Times {
    fn first(&self, view: usize) -> f64 {
        self.first[view]
    }
    fn between(&self, from: usize, to: usize) -> f64 {
        self.between[from * self.first.len() + to]
    }
}

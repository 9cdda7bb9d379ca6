//! What is covered and what each view would still add.

use crate::task::Task;

/// Gains of all views after some were taken.
#[derive(Clone, Debug, Default)]
pub(crate) struct Cover {
    /// Looks at each class.
    looks: Vec<u16>,
    /// Uncovered weight of each view.
    gains: Vec<f64>,
    /// Uncovered classes of each view; 0 for views taken.
    left: Vec<u32>,
    weight: f64,
}

impl Cover {
    pub(crate) fn new(task: &Task) -> Self {
        Self {
            looks: vec![0; task.class_count()],
            gains: (0..task.len())
                .map(|v| task.classes(v).iter().map(|&c| task.weight(c)).sum())
                .collect(),
            left: (0..task.len())
                .map(|v| task.classes(v).len() as u32)
                .collect(),
            weight: 0.0,
        }
    }

    /// Weight covered.
    pub(crate) fn weight(&self) -> f64 {
        self.weight
    }

    /// Weight that a view would add; 0 if it shows nothing new or was taken.
    #[inline]
    pub(crate) fn gain(&self, view: usize) -> f64 {
        if self.left[view] == 0 {
            0.0
        } else {
            self.gains[view]
        }
    }

    /// Weight of a class that is not covered yet, however many looks it takes.
    #[inline]
    pub(crate) fn remaining(&self, task: &Task, class: u32) -> f64 {
        let look = self.looks[class as usize];
        if task.single_look() {
            if look == 0 { task.weight(class) } else { 0.0 }
        } else {
            task.levels(class)[usize::from(look)..].iter().sum()
        }
    }

    /// Takes a view; returns the steps it cost.
    pub(crate) fn take(&mut self, task: &Task, view: usize) -> usize {
        self.weight += self.gain(view);
        let mut steps = task.classes(view).len();
        for &class in task.classes(view) {
            let look = usize::from(self.looks[class as usize]);
            self.looks[class as usize] += 1;
            if task.single_look() && look > 0 {
                continue;
            }
            let levels = task.levels(class);
            let (was, is) = (levels[look], levels.get(look + 1).copied().unwrap_or(0.0));
            let used_up = was > 0.0 && is == 0.0;
            for &other in task.views_of(class) {
                let other = other as usize;
                self.gains[other] -= was - is;
                if used_up {
                    // A view taken before shows the class too, with nothing left to lose.
                    self.left[other] = self.left[other].saturating_sub(1);
                    if self.left[other] == 0 {
                        self.gains[other] = 0.0; // no drift from subtraction
                    }
                }
            }
            steps += levels.len();
        }
        self.left[view] = 0;
        steps
    }
}

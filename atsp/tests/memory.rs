//! What the solver takes from the allocator: nothing per kick, nothing on a second call, and within its promise.
#![allow(missing_docs, clippy::unwrap_used)]
// A counting allocator is the only way to see allocations; it forwards everything to the system's.
#![allow(unsafe_code)]

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

use atsp::{FromFn, Params, Problem, Proof, Solver};

struct Counting;

thread_local! {
    static CALLS: Cell<usize> = const { Cell::new(0) };
    static HELD: Cell<isize> = const { Cell::new(0) };
    static MOST: Cell<isize> = const { Cell::new(0) };
}

fn note(bytes: isize) {
    CALLS.with(|c| c.set(c.get() + usize::from(bytes > 0)));
    let held = HELD.with(|h| {
        h.set(h.get() + bytes);
        h.get()
    });
    MOST.with(|m| m.set(m.get().max(held)));
}

// SAFETY: every call is forwarded unchanged to the system's allocator, which keeps the contract; `note` touches only
// cells without destructors, so it neither allocates nor fails at the end of a thread.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        note(layout.size() as isize);
        unsafe { System.alloc(layout) }
    }
    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        note(-(layout.size() as isize));
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

fn costs(n: usize) -> FromFn<impl Fn(usize, usize) -> f64> {
    FromFn::new(n, |a, b| ((a * 7919 + b * 104_729) % 10_007) as f64)
}

/// Allocations and most bytes held during a call.
fn measure(solver: &mut Solver, n: usize, params: &Params) -> (usize, isize) {
    let before = HELD.with(Cell::get);
    CALLS.with(|c| c.set(0));
    MOST.with(|m| m.set(before));
    solver
        .solve(&costs(n), Problem::Path { start: 1, end: 0 }, params)
        .unwrap();
    (CALLS.with(Cell::get), MOST.with(Cell::get) - before)
}

#[test]
fn kicks_and_second_calls_allocate_nothing_but_the_answer() {
    for proof in [
        Proof::Assignment,
        Proof::Effort {
            steps: 30,
            branches: 30,
        },
    ] {
        let few = Params {
            kicks: 10,
            proof,
            ..Params::default()
        };
        let many = Params { kicks: 5000, ..few };
        let mut solver = Solver::new();
        measure(&mut solver, 60, &many);
        assert_eq!(measure(&mut solver, 60, &few).0, 1, "the order");
        assert_eq!(measure(&mut solver, 60, &many).0, 1, "the order");
    }
}

#[test]
fn memory_is_bounded() {
    for n in [10, 20, 60, 150] {
        let params = Params {
            kicks: 500,
            proof: Proof::Effort {
                steps: 30,
                branches: 100,
            },
            ..Params::default()
        };
        let (_, most) = measure(&mut Solver::new(), n, &params);
        let promised = (64 * n * n + 1024 * n) as isize;
        assert!(
            most <= promised,
            "{n} nodes: {most} bytes, {promised} promised"
        );
    }
}

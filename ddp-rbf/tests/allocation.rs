//! Once made, a controller does not allocate.
#![allow(missing_docs, clippy::unwrap_used, unsafe_code)]

use ddp_rbf::nalgebra::{SVector, vector};
use ddp_rbf::{
    Barrier, Chain, Constraint, DriveArm, InputBox, Joint, LinkSphere, Mpc, Options, PairClearance,
    StateBox, Tracking,
};
use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

thread_local! {
    static COUNT: Cell<usize> = const { Cell::new(0) };
}

/// The system's allocator, counting requests of this thread.
struct Counting;

// SAFETY: everything is passed on to the system's allocator; the counter is a plain cell of the thread.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        let _ = COUNT.try_with(|c| c.set(c.get() + 1));
        // SAFETY: the caller's layout is passed on as it is.
        unsafe { System.alloc(layout) }
    }
    unsafe fn dealloc(&self, at: *mut u8, layout: Layout) {
        // SAFETY: the block came from the system's allocator with this layout.
        unsafe { System.dealloc(at, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

#[test]
fn control_steps_do_not_allocate() {
    let n = 20;
    let chain = Chain::new(
        true,
        [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        [0.0, 0.0, 0.5],
        vec![
            Joint {
                d: 0.1,
                a: 0.4,
                alpha: 0.0,
            };
            2
        ],
        vec![
            LinkSphere {
                link: 0,
                center: [0.3, 0.0, 0.6],
                radius: 0.2,
            },
            LinkSphere {
                link: 2,
                center: [0.0; 3],
                radius: 0.1,
            },
        ],
    )
    .unwrap();
    let barrier = Barrier::default();
    let inputs = InputBox::new(
        SVector::from_element(-1.0),
        SVector::from_element(1.0),
        barrier,
    );
    let joints = StateBox {
        limits: vec![(3, -2.0, 2.0), (4, -2.0, 2.0)],
        barrier,
    };
    let own = PairClearance {
        chain: &chain,
        pairs: &[(0, 1)],
        margin: 0.0,
        barrier,
        name: "own",
    };
    let groups: [&dyn Constraint<5, 4>; 3] = [&inputs, &joints, &own];
    let goal = vector![0.5, 0.3, 0.5, 1.0, -1.0];
    let cost = Tracking::new(
        vec![goal; n + 1],
        vec![SVector::zeros(); n],
        0.1,
        SVector::from_element(5.0),
        SVector::from_element(0.1),
        SVector::from_element(10.0),
    );
    let mut mpc = Mpc::<5, 4>::new(n, 0.1).unwrap();
    let mut x = vector![0.0, 0.0, 0.0, 1.5, 0.5];
    let before = COUNT.with(Cell::get);
    for _ in 0..5 {
        mpc.step(&DriveArm, &cost, &groups, &x, &Options::real_time())
            .unwrap();
        x = mpc.states()[1];
        mpc.shift(0.1);
    }
    mpc.prepare(&DriveArm, &cost, &groups).unwrap();
    x += mpc.react(&x).fixed_rows::<4>(0).push(0.0) * 1e-3;
    mpc.commit(&DriveArm, &x).unwrap();
    mpc.step_from_both(&DriveArm, &cost, &groups, &x, &Options::real_time())
        .unwrap();
    assert_eq!(COUNT.with(Cell::get) - before, 0);
}

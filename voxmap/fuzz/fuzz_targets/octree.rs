//! Any bytes as `.bt` and `.ot`; what can be read can be written and read again.
#![no_main]

use libfuzzer_sys::fuzz_target;
use voxmap::SensorModel;
use voxmap::io::OcTree;

fuzz_target!(|bytes: &[u8]| {
    if let Ok(tree) = OcTree::read_bt(bytes) {
        assert!(OcTree::read_bt(&tree.write_bt()).is_ok());
        let _ = tree.to_map(&SensorModel::default(), 1 << 16);
    }
    if let Ok(tree) = OcTree::read_ot(bytes) {
        assert!(OcTree::read_ot(&tree.write_ot()).is_ok());
        let _ = tree.to_map(&SensorModel::default(), 1 << 16);
    }
});

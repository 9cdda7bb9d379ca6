//! Kinematics of mobile manipulators: UR5e on a differential-drive base, closed-form IK, collision spheres

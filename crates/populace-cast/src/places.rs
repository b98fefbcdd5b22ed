//! Places of the things that people use in their clips: seats, cars, doors, bars and walls.
//!
//! Unless it says otherwise, a place is in the clip's own space: metres, Y up, with the person at
//! the origin facing +Z.

/// Height in metres of the seat's surface in `Sit`, `Sit_Down` and `Stand_Up`.
pub const SEAT_HEIGHT_M: f32 = 0.45;
/// Distance in metres of the middle of the seat's surface behind the origin, where the person
/// stands before it sits down. The feet of adults stay there.
pub const SEAT_BACK_M: f32 = 0.35;

/// Middle of the surface of a driver's seat in `Get_In` and `Get_Out`, in metres. The person stands
/// beside the car, whose forward direction is +X.
pub const CAR_SEAT_M: [f32; 3] = [0.0, 0.50, 0.95];
/// Edge of a car's roof above its open door in `Get_In` and `Get_Out`: its height and its +Z, in
/// metres. People duck under it. The roof above the seat needs 1.47 m.
pub const CAR_ROOF_M: [f32; 2] = [1.35, 0.60];
/// Height in metres of a car's floor above the ground.
pub const CAR_FLOOR_M: f32 = 0.25;
/// Centre of the steering wheel in `Drive`, in metres. There the seat's surface has its middle at
/// `[0, 0.50, 0]`, and the person faces +Z, the forward direction of the car.
pub const STEERING_WHEEL_M: [f32; 3] = [0.0, 0.88, 0.36];
/// Radius in metres of the rim of the steering wheel.
pub const STEERING_WHEEL_RADIUS_M: f32 = 0.19;
/// Angle in radians by which the upper edge of the steering wheel leans away from the driver.
pub const STEERING_WHEEL_TILT_RAD: f32 = 0.44;

/// Handle of a closed door in `Open_Door`, in metres, for the right hand. The hinge is on the left,
/// at [`DOOR_HINGE_M`], and the door opens towards the person.
pub const DOOR_HANDLE_M: [f32; 3] = [-0.18, 0.95, 0.45];
/// Place of the hinge of the door in `Open_Door`, in metres.
pub const DOOR_HINGE_M: [f32; 3] = [0.72, 0.0, 0.45];
/// Angle in radians by which `Open_Door` pulls the door open.
pub const DOOR_OPEN_RAD: f32 = 0.40;

/// Distance in metres of the wall behind the origin in `Lean`.
pub const LEAN_WALL_M: f32 = 0.30;

/// Height of the bar, and its distance before the origin, in `Push`, as fractions of the body's
/// height: 1 m for a person of 1.75 m.
pub const PUSH_BAR: [f32; 2] = [0.57, 0.26];
/// Width of the box in `Carry` as a fraction of the body's height. Its middle is midway between the
/// hands.
pub const CARRY_WIDTH: f32 = 0.21;

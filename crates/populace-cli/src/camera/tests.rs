//! Tests of cameras with people who walk on straight lines.

use super::*;

/// Two people: 0 walks along +X from the origin at 1.5 m/s, and 1 stands at z = -4.
struct Two;

impl Subject for Two {
    fn bounds(&self) -> Vec<[f32; 3]> {
        vec![[0.0, 0.0, 0.0], [6.0, 1.8, 0.0], [0.0, 1.8, -4.0]]
    }

    fn figure_m(&self) -> [f32; 2] {
        [1.8, 0.4]
    }

    fn closest(&self) -> Option<u64> {
        Some(0)
    }

    fn pose(&self, id: u64, secs: f64) -> Option<Pose> {
        let (position, heading_rad) = match id {
            0 => ([single(1.5 * secs), 0.0, 0.0], TAU / 4.0),
            1 => ([0.0, 0.0, -4.0], 0.0),
            _ => return None,
        };
        Some(Pose { position, heading_rad, eye_m: 1.7 })
    }

    fn describe_ids(&self) -> String {
        "people have the numbers 0 and 1".into()
    }
}

fn camera(view: &str, secs: f64) -> Camera {
    let view = view.parse().unwrap();
    let cameras = Cameras::new(&view, &Two, 1.5).unwrap();
    cameras.at(&|secs| Two.pose(cameras.person()?, secs), secs)
}

/// Returns where a point is in the picture, from -1 to 1 to the right and upwards, and its depth.
fn seen(camera: &Camera, point: [f32; 3]) -> [f32; 3] {
    let [eye, target, up, point] = [camera.eye, camera.target, camera.up, point].map(Vec3::from);
    let forward = (target - eye).normalize();
    let right = forward.cross(up).normalize();
    let (to, slope) = (point - eye, (0.5 * camera.fov_y_rad).tan());
    let depth = to.dot(forward);
    [to.dot(right) / depth / slope / 1.5, to.dot(right.cross(forward)) / depth / slope, depth]
}

#[test]
fn air_is_as_clear_as_the_camera_is_far_away() {
    for view in ["crowd", "orbit"] {
        let camera = camera(view, 3.0);
        let distance = Vec3::from(camera.eye).distance(camera.target.into());
        let cameras = Cameras::new(&view.parse().unwrap(), &Two, 1.5).unwrap();
        let ratio = cameras.least_visibility_m() / distance;
        assert!((ratio - VISIBILITY).abs() < 0.01, "{view}: {ratio}");
    }
    for (view, expected) in [("top", f32::INFINITY), ("iso", f32::INFINITY), ("close", 0.0)] {
        let cameras = Cameras::new(&view.parse().unwrap(), &Two, 1.5).unwrap();
        assert_eq!(cameras.least_visibility_m(), expected, "{view}");
    }
}

/// The same people on a place of 40 x 30 m.
struct OnPlace;

impl Subject for OnPlace {
    fn place(&self) -> Vec<[f32; 3]> {
        [[-20.0, -15.0], [20.0, -15.0], [20.0, 15.0], [-20.0, 15.0]]
            .map(|[x, z]| [x, 0.6, z])
            .to_vec()
    }

    fn bounds(&self) -> Vec<[f32; 3]> {
        Two.bounds()
    }

    fn figure_m(&self) -> [f32; 2] {
        Two.figure_m()
    }

    fn closest(&self) -> Option<u64> {
        Two.closest()
    }

    fn pose(&self, id: u64, secs: f64) -> Option<Pose> {
        Two.pose(id, secs)
    }

    fn describe_ids(&self) -> String {
        Two.describe_ids()
    }
}

#[test]
fn the_camera_top_shows_the_place_and_the_people() {
    let top =
        |subject: &dyn Subject| Cameras::new(&View::Top, subject, 1.5).unwrap().at(&|_| None, 0.0);
    let camera = top(&OnPlace);
    for point in OnPlace.place().into_iter().chain(Two.bounds()) {
        let [x, y, _] = seen(&camera, point);
        assert!(x.abs() < 1.0 && y.abs() < 1.0, "{point:?} is at {x}, {y}");
    }
    let [x, ..] = seen(&top(&Two), [20.0, 0.6, 15.0]);
    assert!(x > 1.0, "without a place only people are shown");
}

#[test]
fn everybody_is_in_the_picture() {
    for (view, secs) in [
        ("crowd", 0.0),
        ("top", 0.0),
        ("iso", 0.0),
        ("orbit", 0.0),
        ("orbit", 17.0),
        ("orbit", 44.0),
    ] {
        let camera = camera(view, secs);
        let mut largest: f32 = 0.0;
        for point in Two.bounds() {
            let [x, y, depth] = seen(&camera, point);
            assert!(depth > camera.near && depth < camera.far / 10.0, "{view}: in haze");
            largest = largest.max(x.abs()).max(y.abs());
        }
        assert!(largest < 1.0 && (largest > 0.8 || view == "orbit"), "{view} {secs}: {largest}");
    }
}

#[test]
fn plans_have_x_to_the_right_and_z_downwards() {
    let top = camera("top", 0.0);
    let middle = [3.0, 0.0, -2.0];
    let [x, y, _] = seen(&top, middle);
    assert!(seen(&top, [4.0, 0.0, -2.0])[0] > x && seen(&top, [3.0, 0.0, -1.0])[1] < y);
}

#[test]
fn cameras_go_with_people() {
    for view in ["close", "follow:0", "eye:0"] {
        let [start, later] = [0.0, 2.0].map(|secs| camera(view, secs));
        for (a, b) in [(start.eye, later.eye), (start.target, later.target)] {
            let moved = Vec3::from(b) - Vec3::from(a);
            assert!((moved - Vec3::new(3.0, 0.0, 0.0)).length() < 1e-4, "{view}: {moved}");
        }
    }
    let follow = camera("follow:0", 0.0);
    assert!(follow.eye[0] < -3.0 && follow.target[0] > 1.0, "behind, looking ahead");
    let eye = camera("eye:1", 5.0);
    assert!((eye.eye[1] - 1.7).abs() < 1e-4 && eye.target[2] > eye.eye[2]);
    assert!(eye.near > 0.2, "a cap reaches 0.15 m farther than the eyes");
    let still = camera("crowd", 0.0);
    assert_eq!((still, still), (camera("crowd", 9.0), camera("crowd", 0.1)));
}

#[test]
fn orbits_come_round_in_a_minute() {
    let [start, half, whole] = [0.0, 30.0, 60.0].map(|secs| Vec3::from(camera("orbit", secs).eye));
    assert!((start - whole).length() < 1e-3 && half.z < -4.0 && start.z > 0.0);
}

#[test]
fn unknown_people_are_refused_with_those_that_exist() {
    let refused = Cameras::new(&"follow:7".parse().unwrap(), &Two, 1.5).err().unwrap();
    let message = refused.error().unwrap().to_string();
    assert!(message.contains('7') && message.contains("0 and 1"), "{message}");
}

/// A wall of 2 m, a metre before somebody, does not hide the head.
#[test]
fn close_cameras_of_places_look_over_walls() {
    let place = Alone(Some([3.0, 1.0, -7.0]));
    let camera = Cameras::new(&View::Close, &place, 1.5).unwrap().at(&|_| None, 0.0);
    let [eye, head] = [Vec3::from(camera.eye), Vec3::new(3.0, 2.7, -7.0)];
    let at_wall = head.lerp(eye, 1.0 / (eye.z - head.z));
    assert!(at_wall.y > 3.0 && eye.y > 3.0, "{camera:?}");
}

/// A place with nobody, or with one person who stands.
struct Alone(Option<[f32; 3]>);

impl Subject for Alone {
    fn bounds(&self) -> Vec<[f32; 3]> {
        self.0.iter().flat_map(|[x, y, z]| [[*x, *y, *z], [*x, y + 1.8, *z]]).collect()
    }

    fn elevation_rad(&self) -> Option<f32> {
        Some(0.6)
    }

    fn figure_m(&self) -> [f32; 2] {
        [1.8, 0.4]
    }

    fn closest(&self) -> Option<u64> {
        self.0.map(|_| 0)
    }

    fn pose(&self, _id: u64, _secs: f64) -> Option<Pose> {
        self.0.map(|position| Pose { position, heading_rad: 0.0, eye_m: 1.7 })
    }

    fn describe_ids(&self) -> String {
        String::new()
    }
}

#[test]
fn ground_around_one_person_is_in_the_picture() {
    for place in [None, Some([3.0, 1.0, -7.0])] {
        let [x, y, z] = place.unwrap_or_default();
        for view in ["crowd", "top", "iso", "orbit"] {
            let camera = Cameras::new(&view.parse().unwrap(), &Alone(place), 1.5).unwrap();
            let camera = camera.at(&|_| None, 0.0);
            for side in [-1.8, 1.8] {
                let [right, up, depth] = seen(&camera, [x + side, y, z]);
                assert!(right.abs() < 1.0 && up.abs() < 1.0 && depth > 0.0, "{view}: {camera:?}");
            }
        }
    }
}

/// The ground rises by half a metre in a metre of X.
#[test]
fn cameras_below_the_ground_are_warned_of() {
    let warning = |view: &View| {
        let cameras = Cameras::new(view, &Two, 1.5).expect("a camera");
        let times = (0_u32..).map(|frame| f64::from(frame) / 10.0);
        cameras.below_ground(times, &|[x, _]| 0.5 * x)
    };
    let at = |x: f32, y: f32| View::At { eye: [x, y, 5.0], target: [0.0; 3] };
    assert_eq!([at(2.0, 1.1), at(-4.0, -1.9)].map(|view| warning(&view)), [None, None]);
    let found = warning(&at(2.0, 0.5)).expect("a warning");
    let wanted = "the camera is below the ground: it is at 2.00, 0.50, 5.00 m, where the ground is \
                  at 1.00 m; the second number is the height";
    assert!(found.starts_with(wanted), "{found}");
    let keys = |last: f32| {
        let key = |time: f32, y: f32| {
            format!("[[key]]\ntime = {time:?}\nfrom = [0.0, {y:?}, 5.0]\nto = [0.0, 1.0, 0.0]\n")
        };
        View::Keys(Keys::parse(&(key(0.0, 3.0) + &key(2.04, last))).expect("keys"))
    };
    assert_eq!(warning(&keys(0.1)), None);
    let found = warning(&keys(-0.1)).expect("a warning");
    assert!(
        found.contains("below the ground 1.90 s after frame 0: it is at 0.00, -0.0"),
        "{found}"
    );
    let known = Cameras::new(&View::Top, &Two, 1.5).expect("a camera");
    assert_eq!(known.below_ground(std::iter::once(0.0), &|_| 1e6), None);
}

//! Slopes and stairs.

use populace::{Ground, Placement};
use populace_locomotion::Goal;

use crate::fixture::Town;

/// Height above the ground of a walker on a slope along +Z, and its speed, after a while.
fn on_slope(slope: f32, velocity: f32) -> (f32, f32) {
    let mut town = Town::new();
    let ground = Ground::plane(1.0, [0.0, slope]).unwrap();
    town.walkers.set_ground(ground.clone());
    let member = town.add(Placement::at([0.0, 1.0, 0.0]));
    town.send(member, 1.0, Goal::Velocity([0.0, velocity]));
    town.run(4.0);
    let mut worst = 0.0_f32;
    for _ in 0..120 {
        town.step();
        let [x, y, z] = town.place(member).position();
        let above = y - ground.height_at(x, z);
        worst = if above.abs() > worst.abs() { above } else { worst };
    }
    (worst, town.velocity(member).length())
}

#[test]
fn bodies_follow_slopes_and_are_slower_on_them() {
    let level = on_slope(0.0, 1.3).1;
    assert!((level - 1.3).abs() < 0.01, "{level}");
    let mut before = level;
    for slope in [0.1, 0.2, 0.4] {
        let (up, up_speed) = on_slope(slope, 1.3);
        let (down, down_speed) = on_slope(-slope, 1.3);
        assert!(up.abs() < 0.03 && down.abs() < 0.03, "{slope}: {up} {down}");
        assert!(up_speed < 0.95 * before, "{slope}: {up_speed} is not slower than {before}");
        assert!(up_speed < down_speed && down_speed < level, "{slope}: {up_speed} {down_speed}");
        let (stands, _) = on_slope(slope, 0.0);
        assert!(stands.abs() < 2e-3, "{slope}: stands {stands} m above the ground");
        before = up_speed;
    }
}

/// Treads of 0.3 m along +Z that rise by 0.15 m each, from z = 2 on.
fn stairs() -> Ground {
    let heights = (0..400).flat_map(|row| {
        let tread = ((row as f32 * 0.05 - 2.0) / 0.3).ceil().clamp(0.0, 20.0);
        [0.15 * tread; 2]
    });
    Ground::height_field([-50.0, 0.0], 0.05, 2, heights.collect()).unwrap()
}

#[test]
fn people_climb_stairs_at_the_speed_of_people() {
    let mut town = Town::new();
    town.walkers.set_ground(stairs());
    let up = town.add_at([0.0, 0.5]);
    let down = town.add(Placement::at([0.0, 3.0, 10.0]));
    town.send(up, 1.34, Goal::Velocity([0.0, 1.34]));
    town.send(down, 1.34, Goal::Velocity([0.0, -1.34]));
    let mut speeds = [Vec::new(), Vec::new()];
    let mut heights = [0.0, 3.0];
    for _ in 0..720 {
        town.step();
        for (nth, member) in [up, down].into_iter().enumerate() {
            let [x, y, z] = town.place(member).position();
            if (3.0..7.0).contains(&z) {
                speeds[nth].push(town.velocity(member).length());
                let below = stairs().height_at(x, z);
                assert!((y - below).abs() < 0.16, "{nth}: {y} on {below} at {z}");
                let rises = if nth == 0 { y - heights[0] } else { heights[1] - y };
                assert!((-1e-4..0.03).contains(&rises), "{nth}: {rises} m in a frame at {z}");
            }
            heights[nth] = y;
        }
    }
    // Weidmann's figures for stairs of about this slope.
    for (speeds, wanted) in speeds.iter().zip([0.61, 0.69]) {
        let mean = speeds.iter().sum::<f32>() / speeds.len() as f32;
        assert!((mean / wanted - 1.0).abs() < 0.05, "{mean} m/s, not {wanted}");
    }
    assert!((town.place(up).position()[1] - 3.0).abs() < 0.01, "it has not come to the top");
}

//! The court's motion against the same rays and cameras in f64: the nearest hit by other formulas, seen by both cameras.

use super::*;
use crate::contract::MotionRequest;
use crate::readback::linear_rgba;

/// The nearest distance along `d`, a unit vector, at which a ray from `o` meets the court.
fn distance(o: DVec3, d: DVec3) -> Option<f64> {
    let mut found = Vec::new();
    if d.y < 0.0 {
        found.push(-o.y / d.y);
    }
    for [x, y, z, radius] in SPHERES.map(|s| s.map(f64::from)) {
        let to = o - DVec3::new(x, y, z);
        let (b, c) = (to.dot(d), to.length_squared() - radius * radius);
        if b * b > c {
            found.push(-b - (b * b - c).sqrt());
        }
    }
    for i in 0..COLUMNS {
        let angle = (i as f64 + 0.5) / COLUMNS as f64 * TAU;
        let (x, z) = (o.x - COLUMN_RING * angle.cos(), o.z - COLUMN_RING * angle.sin());
        let (a, b, c) = (d.x * d.x + d.z * d.z, x * d.x + z * d.z, x * x + z * z - 0.42 * 0.42);
        if b * b > a * c {
            let t = (-b - (b * b - a * c).sqrt()) / a;
            found.extend((0.0..=4.4).contains(&(o.y + t * d.y)).then_some(t));
        }
    }
    for (middle, half) in BLOCK_MIDDLES.iter().zip(BLOCK_HALVES) {
        let spans = (0..3).map(|axis| {
            let at = f64::from(middle[axis]) - o[axis];
            let ends = [(at - f64::from(half[axis])) / d[axis], (at + f64::from(half[axis])) / d[axis]];
            [ends[0].min(ends[1]), ends[0].max(ends[1])]
        });
        let [enter, leave] = spans.fold([f64::NEG_INFINITY, f64::INFINITY], |a, b| [a[0].max(b[0]), a[1].min(b[1])]);
        found.extend((enter <= leave).then_some(enter));
    }
    found.into_iter().filter(|&t| t > 1e-3).min_by(f64::total_cmp)
}

/// Where a camera sees a direction from its eye: display pixels, and the part of it along the viewing axis.
fn seen(display: &Display, camera: &Camera, direction: DVec3) -> ([f64; 2], f64) {
    let depth = direction.dot(camera.forward);
    let mm = [direction.dot(camera.right), direction.dot(camera.up)].map(|x| x / depth * display.distance_mm());
    (display.px_from_mm(mm), depth)
}

#[test]
fn motion_is_that_of_hit_points_between_two_cameras() {
    let gpu = Gpu::headless().expect("a device");
    let display = Display::new("test", [320, 180], [510.0, 287.0], 590.0).expect("in range");
    for (camera, speed) in [("fly", 6.0), ("fly", -40.0), ("pan", 6.0), ("pan", 60.0), ("static", 6.0)] {
        let given = Parameters::from([
            ("camera".to_owned(), experiments::catalogue::ParameterValue::Text(camera.to_owned())),
            ("camera_speed".to_owned(), experiments::catalogue::ParameterValue::Number(speed)),
        ]);
        let parameters = experiments::catalogue::complete_parameters(&info().parameters, &given).expect("known");
        let motion = Motion::read(&parameters).expect("known");
        let (since_s, now_s) = (0.9, 0.9 + 1.0 / 60.0);
        let mut scene = make(&gpu, &display, &parameters).expect("it ships");
        // A coarse view that reaches past the display's edge, as a jittered layer's does.
        let view = View { origin_px: [-1.3, 0.7], size_px: [330.0, 186.0], target_px: [110, 62] };
        let [drawn, moved] = ["drawn", "moved"].map(|label| pass::linear_texture(&gpu, label, view.target_px));
        let target = pass::view(&moved);
        let request =
            DrawRequest { motion: Some(MotionRequest { since_s, target: &target }), ..DrawRequest::of(view, now_s) };
        let mut encoder = gpu.device.create_command_encoder(&Default::default());
        scene.draw(&gpu, &mut encoder, &request, &pass::view(&drawn)).expect("it draws");
        gpu.queue.submit([encoder.finish()]);
        let found = linear_rgba(&gpu, &moved).expect("it comes back");

        // The cameras alone, without the device.
        let camera_at = |animation_s: f64| {
            let angle = (62.0 + motion.along_deg(animation_s)).to_radians();
            let eye = DVec3::new(11.0 * angle.cos(), 1.75 + 0.25 * (1.5 * angle).sin(), 11.0 * angle.sin());
            let forward = DQuat::from_rotation_y(motion.aside_deg(animation_s).to_radians())
                * (DVec3::new(0.0, 1.25, 0.0) - eye).normalize();
            let right = forward.cross(DVec3::Y).normalize();
            Camera { eye, right, up: right.cross(forward), forward }
        };
        let (now, then) = (camera_at(now_s), camera_at(since_s));
        let (mut worst_px, mut worst_depth, mut outliers, mut farthest_px, mut skies) =
            (0.0_f64, 0.0_f64, 0, 0.0_f64, 0);
        for (index, texel) in found.chunks_exact(4).enumerate() {
            let texel: [f64; 4] = std::array::from_fn(|i| f64::from(texel[i]));
            let (i, j) = (index as u32 % 110, index as u32 / 110);
            let px = [-1.3 + (f64::from(i) + 0.5) * 3.0, 0.7 + (f64::from(j) + 0.5) * 3.0];
            let mm = display.mm_from_px(px);
            let d = (now.forward + mm[0] / display.distance_mm() * now.right + mm[1] / display.distance_mm() * now.up)
                .normalize();
            let hit = distance(now.eye, d);
            let from_then = hit.map_or(d, |t| now.eye + t * d - then.eye);
            let (place, depth_then) = seen(&display, &then, from_then);
            let expected = [
                place[0] - px[0],
                place[1] - px[1],
                hit.map_or(0.0, |_| 1.0 / depth_then),
                hit.map_or(0.0, |t| 1.0 / (t * d.dot(now.forward))),
            ];
            skies += usize::from(hit.is_none());
            let apart_px = (texel[0] - expected[0]).hypot(texel[1] - expected[1]);
            let apart_depth =
                (2..4).map(|i| (texel[i] - expected[i]).abs() / expected[i].max(1e-3)).fold(0.0, f64::max);
            // On the last digit of an edge, the shader's ray may meet the other side.
            if apart_depth > 0.01 {
                outliers += 1;
                continue;
            }
            let moved_px = expected[0].hypot(expected[1]);
            farthest_px = farthest_px.max(moved_px);
            worst_px = worst_px.max(apart_px - moved_px / 1024.0);
            worst_depth = worst_depth.max(apart_depth);
        }
        println!(
            "{camera} {speed}: up to {farthest_px:.2} px, {skies} of 6820 sky; worst error {worst_px:.1e} px beyond the \
             rounding of halves, inverse depth {worst_depth:.1e}, {outliers} at edges"
        );
        assert!(worst_px < 5e-4 && worst_depth < 1.5e-3 && outliers <= 3);
        assert!(skies > 200 && (camera == "static") == (farthest_px < 1e-9));
    }
}

//! The same scene at another frame rate: inputs keep their times, frames come evenly.

use ac_golden_traces::{Scene, scene::FrameRun};

/// Slack when a time is put into a frame, s: sums of frame lengths are not exact.
const SLACK: f64 = 1e-9;

/// The scene with frames of `1 / rate` s for as long as the original lasts. A step of the script is carried out in the first frame that is
/// not earlier than its own: inputs are sampled at the frame rate, as a client does it. `None` where frames are what the scene is about
/// (tag `clock`), or where there would be none.
pub fn at_rate(scene: &Scene, rate: u32) -> Option<Scene> {
    let unsuitable = scene.features.iter().any(|tag| tag == "clock") || scene.area() == "clock";
    let length: f64 = scene
        .frames
        .iter()
        .map(|run| run.dt * f64::from(run.count))
        .sum();
    let count = (length * f64::from(rate) - SLACK).ceil();
    if unsuitable || !(1.0..1e8).contains(&count) {
        return None;
    }
    let dt = 1.0 / f64::from(rate);
    let times: Vec<f64> = scene.times().collect();
    let mut resampled = Scene {
        frames: vec![FrameRun {
            dt,
            count: count as u32,
        }],
        ..scene.clone()
    };
    for step in &mut resampled.script {
        let time = times.get(step.frame as usize)? - scene.start_time;
        // Frame 0 is at `dt`.
        let frame = (time / dt - SLACK * f64::from(rate)).ceil() - 1.0;
        step.frame = frame.clamp(0.0, count - 1.0) as u32;
    }
    Some(resampled)
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    fn scene() -> Scene {
        let text = r#"{"schema":"ac-scene/1","name":"a/b","summary":"s","world":"w","start_time":1000,"frames":[{"dt":0.1,"count":10}],"track":["0x1"],
            "script":[{"frame":0,"guid":"0x1","do":"stop_completely"},{"frame":4,"guid":"0x1","do":"stop_completely"}]}"#;
        Scene::parse(text.as_bytes(), Path::new("b")).unwrap()
    }

    #[test]
    fn inputs_keep_their_times() {
        let fast = at_rate(&scene(), 20).unwrap();
        assert_eq!(fast.frame_count(), 20);
        let frames: Vec<u32> = fast.script.iter().map(|step| step.frame).collect();
        // 0.1 s and 0.5 s: the frames at 0.1 s and 0.5 s.
        assert_eq!(frames, [1, 9]);
        let slow = at_rate(&scene(), 4).unwrap();
        let frames: Vec<u32> = slow.script.iter().map(|step| step.frame).collect();
        assert_eq!(frames, [0, 1]);
    }

    #[test]
    fn the_same_rate_is_the_same_scene() {
        assert_eq!(at_rate(&scene(), 10).unwrap(), scene());
    }

    #[test]
    fn scenes_about_frames_have_no_other_rate() {
        let mut clock = scene();
        clock.features.push("clock".into());
        assert_eq!(at_rate(&clock, 10), None);
    }
}

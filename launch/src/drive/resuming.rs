//! What a stack that stays up does with where its robot was left, and with where it is.

use super::last_pose::{PAUSE, write};
use super::session::Session;
use std::path::PathBuf;
use std::time::Instant;
use zeronav_console::terminal::note;
use zeronav_msgs::Pose;
use zeronav_msgs::task::PoseEstimate;
use zeronav_supervise::stack::Stack;

impl Session<'_> {
    /// Puts the robot where it was left, if that is asked for, and saves where it is now and then.
    pub(super) fn update_last_pose(&mut self, stack: &mut Stack) {
        let Some(last_pose) = &mut self.last_pose else {
            return;
        };
        if let Some(pose) = last_pose.resumes {
            if self.given_pose.is_some() {
                // A person has said so since.
                last_pose.resumes = None;
            } else if self.collector.odometry.is_some() {
                self.resume_last_pose(stack, pose);
            }
            return;
        }
        let is_known = self.phase.is_ready() && self.collector.is_pose_confirmed();
        let pose = self.collector.estimate().filter(|_| is_known);
        last_pose.first = last_pose.first.or(pose);
        if last_pose.looked.elapsed() < PAUSE {
            return;
        }
        last_pose.looked = Instant::now();
        let is_writing = last_pose
            .writing
            .as_ref()
            .is_some_and(|it| !it.is_finished());
        if is_writing {
            return;
        }
        if let Some((file, text)) = self.last_pose_text() {
            // A slow disk does not hold up who watches the stack.
            let thread = std::thread::Builder::new().name("last-pose".to_owned());
            let writing = thread.spawn(move || write(&file, &text)).ok();
            if let Some(last_pose) = &mut self.last_pose {
                last_pose.writing = writing;
            }
        }
    }

    fn resume_last_pose(&mut self, stack: &mut Stack, pose: [f64; 3]) {
        let [x_m, y_m, yaw_rad] = pose;
        let checked = self.check_pose(&Pose::new(x_m, y_m, yaw_rad));
        if checked.is_ok() && self.relocate(stack, pose).is_err() {
            // There is no memory for the message: it is tried again.
            return;
        }
        if let Some(last_pose) = &mut self.last_pose {
            last_pose.resumes = None;
        }
        note(&match checked {
            Ok(()) => format!("the robot was left at {x_m:.2} {y_m:.2} {yaw_rad:.2}"),
            Err(why) => format!("no pose is resumed: {why}"),
        });
    }

    /// The file, and what is to be written to it.
    fn last_pose_text(&mut self) -> Option<(PathBuf, String)> {
        let located_tick = self.collector.located?.0;
        let is_given = |given: &PoseEstimate| given.from_tick > located_tick;
        // The map does not know of it yet.
        let is_old = self.given_pose.as_ref().is_some_and(is_given);
        let pose = self
            .collector
            .estimate()
            .filter(|_| self.collector.is_pose_confirmed() && !is_old)?;
        let was_told = self.given_pose.is_some();
        let last_pose = self.last_pose.as_mut().filter(|it| it.resumes.is_none())?;
        Some((last_pose.file.clone(), last_pose.text(pose, was_told)?))
    }

    /// Saves where the robot is in the end, if it knows.
    pub(super) fn save_last_pose(&mut self) {
        if let Some(writing) = self.last_pose.as_mut().and_then(|it| it.writing.take()) {
            let _ = writing.join();
        }
        if let Some((file, text)) = self.last_pose_text().filter(|_| self.phase.is_ready()) {
            write(&file, &text);
        }
    }
}

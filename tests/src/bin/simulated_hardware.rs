//! A simulated robot behind a pipe, as the hardware of a driver that knows nothing of this project.
//!
//! `simulated_hardware CONFIG TICK_HZ` simulates in real time. A line for each measurement goes to standard output, with
//! the time since the start in nanoseconds: `O NS X Y YAW V W`, `S NS ANGLE_MIN ANGLE_INCREMENT TIME_INCREMENT RANGE_MIN
//! RANGE_MAX RANGES...`, and for tests the truth, `T NS X Y YAW V CONTACTS_MOVING CONTACTS_STANDING`. Lines `V W` on
//! standard input are commands; its end ends the program.
#![allow(clippy::print_stdout, reason = "its output")]

use std::fmt::Write as _;
use std::io::{BufRead, Write as _};
use std::process::ExitCode;
use std::sync::mpsc::{TryRecvError, channel};
use std::time::{Duration, Instant};
use zeronav_robot_sim::{SimConfig, Simulator};

fn main() -> ExitCode {
    match simulate() {
        Ok(()) => ExitCode::SUCCESS,
        Err(why) => {
            let _ = writeln!(std::io::stderr(), "simulated_hardware: {why}");
            ExitCode::from(2)
        }
    }
}

fn simulate() -> Result<(), String> {
    let mut arguments = std::env::args().skip(1);
    let mut argument = |name: &str| arguments.next().ok_or(format!("{name} is missing"));
    let (file, tick_hz) = (argument("CONFIG")?, argument("TICK_HZ")?);
    let tick_hz: f64 = tick_hz.parse().map_err(|_| "TICK_HZ is no number")?;
    let text = std::fs::read_to_string(&file).map_err(|error| format!("{file}: {error}"))?;
    let config: SimConfig = toml::from_str(&text).map_err(|error| format!("{file}: {error}"))?;
    let loaded = zeronav_world_files::load(&config.world);
    let (world, _) = loaded.map_err(|error| format!("{file}: {error}"))?;
    let tick = Duration::from_secs_f64(tick_hz.recip());
    let tick_ns = u64::try_from(tick.as_nanos()).map_err(|_| "TICK_HZ is too small")?;
    let simulator = Simulator::new(&config, world, 1, tick_ns);
    let mut simulator = simulator.map_err(|error| error.to_string())?;
    let (sender, commands) = channel();
    std::thread::spawn(move || {
        for line in std::io::stdin().lock().lines().map_while(Result::ok) {
            let mut numbers = line.split(' ').filter_map(|it| it.parse::<f64>().ok());
            if let (Some(v_mps), Some(w_radps)) = (numbers.next(), numbers.next()) {
                let _ = sender.send((v_mps, w_radps, Instant::now()));
            }
        }
    });
    let mut newest: Option<Instant> = None;
    let (mut ranges, mut obstacles) = (vec![0.0; simulator.n_beams()], Vec::new());
    let start = Instant::now();
    for n in 1_u32.. {
        std::thread::sleep((tick * n).saturating_sub(start.elapsed()));
        loop {
            match commands.try_recv() {
                Ok((v_mps, w_radps, at)) => {
                    simulator.set_command(v_mps, w_radps);
                    newest = Some(at);
                }
                Err(TryRecvError::Empty) => break,
                Err(TryRecvError::Disconnected) => return Ok(()),
            }
        }
        let age = newest.map_or(u128::from(u64::MAX), |at| at.elapsed().as_nanos());
        let run_ns = tick_ns * u64::from(n);
        simulator.step(run_ns, u64::try_from(age).unwrap_or(u64::MAX));
        let mut lines = String::new();
        let it = simulator.odometry();
        let pose = it.pose;
        let (v, w) = (it.v_mps, it.w_radps);
        let _ = writeln!(
            lines,
            "O {run_ns} {} {} {} {v} {w}",
            pose.x_m, pose.y_m, pose.yaw_rad
        );
        if let (Some(due), Some(scan)) = (simulator.scan_due(), simulator.scan(&mut ranges)) {
            let (from, step) = (scan.angle_min_rad, scan.angle_increment_rad);
            let (time, min, max) = (scan.time_increment_s, scan.range_m_min, scan.range_m_max);
            let ns = due.capture_run_ns;
            let _ = write!(lines, "S {ns} {from} {step} {time} {min} {max}");
            for range in &ranges {
                let _ = write!(lines, " {range}");
            }
            lines.push('\n');
        }
        if simulator.truth_due() {
            let truth = simulator.truth(&mut obstacles);
            let (pose, v) = (truth.pose, truth.v_mps);
            let (moving, standing) = (truth.contacts_moving, truth.contacts_standing);
            let _ = writeln!(
                lines,
                "T {run_ns} {} {} {} {v} {moving} {standing}",
                pose.x_m, pose.y_m, pose.yaw_rad
            );
        }
        let mut out = std::io::stdout().lock();
        let sent = out.write_all(lines.as_bytes()).and_then(|()| out.flush());
        if sent.is_err() {
            return Ok(());
        }
    }
    Ok(())
}

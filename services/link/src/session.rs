//! The way to the other host: a session of Zenoh between two named ends, with nothing that scouts.

use crate::config::LinkConfig;
use crate::queue::FrameQueue;
use serde_json::{Value, json};
use std::mem::ManuallyDrop;
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use zenoh::Wait;
use zenoh::pubsub::Publisher;
use zenoh::qos::{CongestionControl, Priority};
use zeronav_shell::StartError;
use zeronav_shell::doorbell::Waker;

/// How long nothing may come before an end counts as gone. [ms]
const LEASE_MS: u32 = 4_000;

/// Bytes that the kernel keeps on the way out: what waits there is late, what waits in a topic is superseded.
const KERNEL_BYTES: u32 = 32 * 1024;

/// For how long a piece of a frame may wait for a narrow way before Zenoh closes the connection: no longer than until the
/// end would count as gone. [us]
const NARROW_US: u32 = 1_000 * LEASE_MS;

/// How long the last frames may take to go out.
const LEAVE_LIMIT: Duration = Duration::from_millis(500);
const LEAVE_PAUSE: Duration = Duration::from_millis(2);

/// Time between two tries to connect. [ms]
const RETRY_MS: u32 = 250;

/// A session, its two queues, and the thread that sends.
#[derive(Debug)]
pub struct Session {
    /// What is to be sent.
    pub outbox: Arc<FrameQueue>,
    /// What has come.
    pub inbox: Arc<FrameQueue>,
    sender: Option<JoinHandle<()>>,
    zenoh: ManuallyDrop<zenoh::Session>,
}

impl Session {
    /// Opens the own end. Whoever connects tries again and again, for as long as it takes; `waker` is woken
    /// whenever something has come.
    ///
    /// # Errors
    /// [`StartError::System`] naming what cannot be: an address that is taken, keys that cannot be read.
    pub fn open(config: &LinkConfig, waker: Waker) -> Result<Self, StartError> {
        let end = format!("{}{}", config.listen, config.connect);
        let failed = |error: zenoh::Error| StartError::system(format!("opening {end}"), error);
        let zenoh = zenoh::open(ends(config).map_err(failed)?)
            .wait()
            .map_err(failed)?;
        let (outbox, inbox) = (Arc::default(), Arc::<FrameQueue>::default());
        let came = Arc::clone(&inbox);
        zenoh
            .declare_subscriber(key(&config.other))
            .callback(move |sample| {
                came.push_when_there_is_room(sample.payload().to_bytes().into_owned());
                waker.wake();
            })
            .background()
            .wait()
            .map_err(failed)?;
        let publisher = zenoh
            .declare_publisher(key(&config.host))
            .congestion_control(CongestionControl::Block)
            .priority(Priority::RealTime)
            .express(true)
            .wait()
            .map_err(failed)?;
        let queue = Arc::clone(&outbox);
        let sender = std::thread::Builder::new()
            .name("sender".to_owned())
            .spawn(move || send(&queue, &publisher))
            .map_err(|error| StartError::system("starting a thread", error))?;
        Ok(Self {
            outbox,
            inbox,
            sender: Some(sender),
            zenoh: ManuallyDrop::new(zenoh),
        })
    }
}

impl Drop for Session {
    fn drop(&mut self) {
        self.inbox.close();
        self.outbox.close();
        // What is in the queue still goes out: the last beat says that this end leaves.
        let since = Instant::now();
        let is_sending = |sender: &JoinHandle<()>| !sender.is_finished();
        while self.sender.as_ref().is_some_and(is_sending) {
            if since.elapsed() > LEAVE_LIMIT {
                // The way is cut: Zenoh would wait for it as well, and ends with the process.
                return;
            }
            std::thread::sleep(LEAVE_PAUSE);
        }
        let _ = self.zenoh.close().wait();
    }
}

fn send(queue: &FrameQueue, publisher: &Publisher<'_>) {
    while let Some(frame) = queue.wait() {
        // Without the other end a frame goes nowhere, and counts as lost there.
        if let Err(error) = publisher.put(frame).wait() {
            tracing::debug!(%error, "not sent");
        }
    }
}

/// What a host's frames are published under.
fn key(host: &str) -> String {
    format!("zeronav/{host}")
}

fn ends(config: &LinkConfig) -> Result<zenoh::Config, zenoh::Error> {
    let mut zenoh = zenoh::Config::default();
    let mut set =
        |key: &str, value: &serde_json::Value| zenoh.insert_json5(key, &value.to_string());
    let list = |end: &str| -> Value {
        let ends = [end].into_iter().filter(|end| !end.is_empty());
        ends.collect::<Vec<_>>().into()
    };
    set("mode", &"peer".into())?;
    set("scouting/multicast/enabled", &false.into())?;
    set("scouting/gossip/enabled", &false.into())?;
    set("listen/endpoints", &list(&config.listen))?;
    set("connect/endpoints", &list(&config.connect))?;
    set("connect/timeout_ms", &(-1).into())?;
    set("connect/exit_on_failure", &false.into())?;
    let retry = json!({ "period_init_ms": RETRY_MS, "period_max_ms": 2 * RETRY_MS, "period_increase_factor": 2.0 });
    set("connect/retry", &retry)?;
    set("transport/link/tx/lease", &LEASE_MS.into())?;
    let narrow = "transport/link/tx/queue/congestion_control/block/wait_before_close";
    set(narrow, &NARROW_US.into())?;
    set("transport/link/tcp/so_sndbuf", &KERNEL_BYTES.into())?;
    set("transport/link/tls/so_sndbuf", &KERNEL_BYTES.into())?;
    if !config.keys.as_os_str().is_empty() {
        let file = |name: &str| config.keys.join(name).display().to_string().into();
        let (own, key) = (
            file(&format!("{}.pem", config.host)),
            file(&format!("{}.key", config.host)),
        );
        set("transport/link/tls/root_ca_certificate", &file("ca.pem"))?;
        // Who connects shows its certificate, too.
        set("transport/link/tls/enable_mtls", &true.into())?;
        for side in ["listen", "connect"] {
            set(&format!("transport/link/tls/{side}_certificate"), &own)?;
            set(&format!("transport/link/tls/{side}_private_key"), &key)?;
        }
    }
    Ok(zenoh)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn zenoh_knows_every_setting() {
        let config = |listen: &str, keys: &str| LinkConfig {
            host: "robot".to_owned(),
            other: "base".to_owned(),
            seats: Vec::new(),
            commands: true,
            scenario: String::new(),
            listen: listen.to_owned(),
            connect: String::new(),
            keys: keys.into(),
        };
        ends(&config("tcp/127.0.0.1:7447", "")).expect("settings");
        ends(&config("tls/localhost:7447", "keys")).expect("settings");
    }
}

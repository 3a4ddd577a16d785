//! What comes over the network, on a thread of its own: the loop of the seat never waits for it.

use crate::config::RosConfig;
use crate::inputs::{Arrived, Event};
use ros2_client::dds::rustdds::mio1::{self, Events, Interest, Poll, Token};
use ros2_client::qos::{Durability, History, QosProfile, WhenFull};
use ros2_client::{MessageInfo, MessageTypeName, Name, Node, Subscription};
use rustix::time::{ClockId, clock_gettime};
use serde::de::DeserializeOwned;
use std::io::ErrorKind;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, TryRecvError, sync_channel};
use std::thread::JoinHandle;
use std::time::Duration;
use zeronav_ros_messages::messages::{LaserScan, Odometry, TfMessage};
use zeronav_shell::clock::now_ns;

/// Messages that wait for the seat. Its loop is never away for so many.
const WAITING_MAX: usize = 256;

/// How often the thread looks whether it is still wanted.
const LOOK: Duration = Duration::from_millis(100);

/// Messages of one topic that are taken in before the others have their turn.
const TURN: usize = 32;

/// `CLOCK_MONOTONIC` minus the time of the system. [ns]
#[must_use]
pub fn host_offset_ns() -> i64 {
    let system = clock_gettime(ClockId::Realtime);
    let system_ns = system.tv_sec.saturating_mul(1_000_000_000) + system.tv_nsec;
    i64::try_from(now_ns())
        .unwrap_or(i64::MAX)
        .saturating_sub(system_ns)
}

/// The receiving end.
#[derive(Debug)]
pub struct Inbox {
    receiver: Receiver<Arrived>,
    counts: Arc<Counts>,
    stop: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

#[derive(Debug, Default)]
struct Counts {
    /// Messages for which there was no room.
    dropped: AtomicU64,
    /// Messages that are no CDR of their type.
    broken: AtomicU64,
}

/// Best effort: it hears publishers of either kind.
fn sensor_qos() -> QosProfile {
    QosProfile::subscription_default().history(History::KeepLast { depth: 10 })
}

/// What is published once, for those that come later, too.
fn static_qos() -> QosProfile {
    QosProfile::publisher_default()
        .reliability_reliable(WhenFull::DEFAULT)
        .durability(Durability::TransientLocal)
        .history(History::KeepLast { depth: 100 })
}

/// A subscription.
///
/// # Errors
/// One line that names the topic.
pub fn subscribe<M: 'static>(
    node: &mut Node,
    name: &str,
    [package, kind]: [&str; 2],
    qos: &QosProfile,
) -> Result<Subscription<M>, String> {
    let failed = |why: &dyn core::fmt::Debug| format!("subscribing to {name}: {why:?}");
    let topic_name = Name::parse(name).map_err(|why| failed(&why))?;
    let kind = MessageTypeName::new(package, kind);
    let topic = node.create_topic(&topic_name, kind, qos);
    let topic = topic.map_err(|why| failed(&why))?;
    (node.create_subscription(&topic, None)).map_err(|why| failed(&why))
}

/// The subscriptions of the robot's side.
struct Subscriptions {
    scan: Subscription<LaserScan>,
    odometry: Subscription<Odometry>,
    tf: Subscription<TfMessage>,
    tf_static: Subscription<TfMessage>,
}

/// What the thread passes messages on with.
struct Post {
    sender: SyncSender<Arrived>,
    counts: Arc<Counts>,
    wake: Box<dyn Fn() + Send>,
}

impl Post {
    /// Passes on what has come; true when there may be more.
    fn take<M: DeserializeOwned + 'static>(
        &self,
        from: &Subscription<M>,
        event: impl Fn(M) -> Event,
    ) -> bool {
        for _ in 0..TURN {
            match from.take() {
                Ok(Some((message, info))) => self.pass(event(message), &info),
                Ok(None) => return false,
                Err(_) => {
                    self.counts.broken.fetch_add(1, Ordering::Relaxed);
                }
            }
        }
        true
    }

    fn pass(&self, event: Event, info: &MessageInfo) {
        // Transforms say nothing by themselves: they are read with what comes next.
        let is_measured = !matches!(event, Event::Transforms(_));
        let arrived = Arrived {
            event,
            came_ns: now_ns(),
            publisher: info.publisher_gid().to_bytes16(),
        };
        if self.sender.try_send(arrived).is_err() {
            self.counts.dropped.fetch_add(1, Ordering::Relaxed);
        }
        if is_measured {
            (self.wake)();
        }
    }
}

impl Inbox {
    /// Subscribes, and begins to hear; `wake` is called for each scan and odometry.
    ///
    /// # Errors
    /// One line that names what cannot be made.
    pub fn open(
        node: &mut Node,
        config: &RosConfig,
        wake: impl Fn() + Send + 'static,
    ) -> Result<Self, String> {
        let sensor = sensor_qos();
        let tf = ["tf2_msgs", "TFMessage"];
        let mut subscriptions = Subscriptions {
            scan: subscribe(
                node,
                &config.scan_topic,
                ["sensor_msgs", "LaserScan"],
                &sensor,
            )?,
            odometry: subscribe(node, &config.odom_topic, ["nav_msgs", "Odometry"], &sensor)?,
            tf: subscribe(node, &config.tf_topic, tf, &sensor)?,
            tf_static: subscribe(node, &config.tf_static_topic, tf, &static_qos())?,
        };
        let poll = Poll::new().map_err(|error| format!("waiting for messages: {error}"))?;
        register(&poll, &mut subscriptions)
            .map_err(|error| format!("waiting for messages: {error}"))?;
        let (sender, receiver) = sync_channel(WAITING_MAX);
        let counts = Arc::new(Counts::default());
        let stop = Arc::new(AtomicBool::new(false));
        let post = Post {
            sender,
            counts: Arc::clone(&counts),
            wake: Box::new(wake),
        };
        let is_over = Arc::clone(&stop);
        let thread = std::thread::Builder::new()
            .name("ros2".to_owned())
            .spawn(move || listen(poll, &subscriptions, &post, &is_over))
            .map_err(|error| format!("starting a thread: {error}"))?;
        Ok(Self {
            receiver,
            counts,
            stop,
            thread: Some(thread),
        })
    }

    /// The next message.
    ///
    /// # Errors
    /// When the thread has ended, which it does not by itself.
    pub fn next(&self) -> Result<Option<Arrived>, String> {
        match self.receiver.try_recv() {
            Ok(arrived) => Ok(Some(arrived)),
            Err(TryRecvError::Empty) => Ok(None),
            Err(TryRecvError::Disconnected) => Err("the thread that hears has ended".to_owned()),
        }
    }

    /// Messages that were no messages of their type.
    #[must_use]
    pub fn broken(&self) -> u64 {
        self.counts.broken.load(Ordering::Relaxed)
    }

    /// Messages for which there was no room.
    #[must_use]
    pub fn dropped(&self) -> u64 {
        self.counts.dropped.load(Ordering::Relaxed)
    }
}

impl Drop for Inbox {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}

fn register(poll: &Poll, subscriptions: &mut Subscriptions) -> std::io::Result<()> {
    let registry = poll.registry();
    let sources: [&mut dyn mio1::event::Source; 4] = [
        &mut subscriptions.scan,
        &mut subscriptions.odometry,
        &mut subscriptions.tf,
        &mut subscriptions.tf_static,
    ];
    for (n, source) in sources.into_iter().enumerate() {
        source.register(registry, Token(n), Interest::READABLE)?;
    }
    Ok(())
}

/// Passes messages on until it is over. Odometry goes first, as in every service.
fn listen(mut poll: Poll, subscriptions: &Subscriptions, post: &Post, is_over: &AtomicBool) {
    let mut events = Events::with_capacity(16);
    let mut is_more = false;
    while !is_over.load(Ordering::Relaxed) {
        // Events come once: whatever is left must be looked at again.
        let timeout = if is_more { Duration::ZERO } else { LOOK };
        match poll.poll(&mut events, Some(timeout)) {
            Err(error) if error.kind() != ErrorKind::Interrupted => return,
            _ => {}
        }
        is_more = post.take(&subscriptions.odometry, |it| Event::Odometry(Box::new(it)))
            | post.take(&subscriptions.scan, Event::Scan)
            | post.take(&subscriptions.tf_static, Event::Transforms)
            | post.take(&subscriptions.tf, Event::Transforms);
    }
}

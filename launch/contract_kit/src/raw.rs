//! Ports without checks: they send any bytes, and read whatever the program sends.

use iceoryx2::node::Node;
use iceoryx2::port::publisher::Publisher;
use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::prelude::{NodeBuilder, ServiceName, SignalHandlingMode, ipc};
use iceoryx2::service::port_factory::publish_subscribe::PortFactory;
use zeronav_msgs::header::Header;
use zeronav_msgs::message::{FNV_OFFSET, Refusal, fnv1a};
use zeronav_msgs::topics::{Envelope, Topic, TopicRow, decode};
use zeronav_shell::Domain;

/// A member of a domain with ports that check nothing.
#[derive(Debug)]
pub(crate) struct RawPeer {
    node: Node<ipc::Service>,
    /// Keeps the membership; dropped after the node.
    _domain: Domain,
}

/// A message as it was read.
#[derive(Debug, Clone)]
pub(crate) struct Received {
    /// Its topic.
    pub row: &'static TopicRow,
    /// Its header, whatever it holds.
    pub header: Header,
    /// Fixed fields.
    pub meta: Vec<u8>,
    /// The slice.
    pub items: Vec<u8>,
    /// Why a reader would reject it.
    pub refusal: Option<Refusal>,
}

impl Received {
    /// The fixed fields as those of topic `T`; `None` on another topic.
    pub(crate) fn meta<T: Topic>(&self) -> Option<T::Meta> {
        (self.row.name == T::ROW.name).then(|| bytemuck::pod_read_unaligned(&self.meta))
    }

    /// The slice as that of topic `T`.
    pub(crate) fn items<T: Topic>(&self) -> Vec<T::Item> {
        let size = size_of::<T::Item>().max(1);
        let items = self.items.chunks_exact(size);
        items.map(bytemuck::pod_read_unaligned).collect()
    }

    /// Hash of everything that has to be the same in two runs: all but clock readings.
    pub(crate) fn hash(&self) -> u64 {
        let header = Header {
            capture_ns: 0,
            checksum: 0,
            stamps: zeronav_msgs::header::Stamps::default(),
            ..self.header
        };
        let state = fnv1a(FNV_OFFSET, self.row.name.as_bytes());
        let state = fnv1a(state, bytemuck::bytes_of(&header));
        fnv1a(fnv1a(state, &self.meta), &self.items)
    }
}

/// Reads everything on a topic.
pub(crate) type RawReader = Box<dyn FnMut(&mut Vec<Received>)>;

type Factory<T> = PortFactory<ipc::Service, [<T as Topic>::Item], <T as Topic>::Envelope>;

/// Sends any bytes on topic `T`.
pub(crate) type RawWriter<T> =
    Publisher<ipc::Service, [<T as Topic>::Item], <T as Topic>::Envelope>;

impl RawPeer {
    /// Joins `domain`.
    ///
    /// # Errors
    /// What the middleware says.
    pub(crate) fn join(domain: Domain) -> Result<Self, String> {
        let config = domain.config().map_err(|error| error.to_string())?;
        let node = NodeBuilder::new()
            .config(&config)
            .signal_handling_mode(SignalHandlingMode::Disabled)
            .create::<ipc::Service>()
            .map_err(|error| format!("joining the domain: {error}"))?;
        Ok(Self {
            node,
            _domain: domain,
        })
    }

    fn open<T: Topic>(&self, row: &'static TopicRow) -> Result<Factory<T>, String> {
        let name = ServiceName::new(row.name).map_err(|error| error.to_string())?;
        self.node
            .service_builder(&name)
            .publish_subscribe::<[T::Item]>()
            .user_header::<T::Envelope>()
            .open()
            .map_err(|error| format!("opening {}: {error:?}", row.name))
    }

    /// Opens a reader that copies everything.
    ///
    /// # Errors
    /// What the middleware says.
    pub(crate) fn reader<T: Topic>(&self, row: &'static TopicRow) -> Result<RawReader, String> {
        let subscriber: Subscriber<ipc::Service, [T::Item], T::Envelope> = self
            .open::<T>(row)?
            .subscriber_builder()
            .create()
            .map_err(|error| format!("reading {}: {error:?}", row.name))?;
        Ok(Box::new(move |seen| {
            while let Ok(Some(sample)) = subscriber.receive() {
                let envelope: &T::Envelope = sample.user_header();
                seen.push(Received {
                    row,
                    header: *envelope.header(),
                    meta: bytemuck::bytes_of(envelope.meta()).to_vec(),
                    items: bytemuck::cast_slice(sample.payload()).to_vec(),
                    refusal: decode::<T>(row, envelope, sample.payload()).err(),
                });
            }
        }))
    }

    /// Opens a writer of slices with up to `len` items.
    ///
    /// # Errors
    /// What the middleware says.
    pub(crate) fn writer<T: Topic>(
        &self,
        row: &'static TopicRow,
        len: usize,
    ) -> Result<RawWriter<T>, String> {
        let pool = row.pool();
        self.open::<T>(row)?
            .publisher_builder()
            .initial_max_slice_len(len.max(1))
            .max_loaned_samples(1)
            .override_sample_preallocation(move |worst| worst.min(pool))
            .create()
            .map_err(|error| format!("writing {}: {error:?}", row.name))
    }
}

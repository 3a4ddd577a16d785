//! A member of a domain with its typed ports.

use crate::domain::Domain;
use crate::error::StartError;
use crate::memory;
use crate::middleware::{self, Erased, Factory, Layout, Receiver, Sender, TopicBuilder};
use crate::raw::{RawReader, RawWriter};
use crate::reader::{Latest, Stream};
use crate::records::{SpanReader, SpanWriter};
use crate::writer::Writer;
use core::any::Any;
use iceoryx2::node::Node;
use iceoryx2::port::subscriber::SubscriberCreateError;
use iceoryx2::prelude::{
    AttributeSpecifier, AttributeVerifier, NodeBuilder, ServiceName, SignalHandlingMode, ipc,
};
use iceoryx2::service::attribute::{AttributeKey, AttributeValue};
use iceoryx2::service::builder::publish_subscribe::PublishSubscribeOpenError;
use zeronav_msgs::role::Role;
use zeronav_msgs::topics::{
    EVENT_MAX, NODES_MAX, READERS_MAX, RINGERS_MAX, SPANS, Topic, TopicRow, TopicVisitor,
    WRITERS_MAX, visit_topics,
};

/// Name of the attribute that carries the schema hash.
const SCHEMA_ATTRIBUTE: &str = "schema";

/// A member of a domain: its role, and the ports of every topic.
#[derive(Debug)]
pub struct Peer {
    role: Role,
    epoch: u32,
    tap: bool,
    node: Erased<Node<ipc::Service>>,
    domain: Domain,
}

/// Keeps the topics of a domain in existence.
#[derive(Debug, Default)]
pub struct Topics {
    held: Vec<Box<dyn Any>>,
}

impl Peer {
    /// Joins `domain` as `role`, started as the `epoch`-th.
    ///
    /// # Errors
    /// [`StartError::System`] when the middleware refuses.
    pub fn join(domain: Domain, role: Role, epoch: u32) -> Result<Self, StartError> {
        let config = domain.config()?;
        let node = NodeBuilder::new()
            .config(&config)
            .signal_handling_mode(SignalHandlingMode::Disabled)
            .create::<ipc::Service>()
            .map_err(|error| StartError::system("joining the domain", error))?;
        let tap = matches!(role, Role::Launch | Role::Tap);
        Ok(Self {
            role,
            epoch,
            tap,
            node: Erased::new(node),
            domain,
        })
    }

    /// Its role.
    #[must_use]
    pub fn role(&self) -> Role {
        self.role
    }

    /// Which start of the role this is.
    #[must_use]
    pub fn epoch(&self) -> u32 {
        self.epoch
    }

    /// The domain.
    #[must_use]
    pub fn domain(&self) -> &Domain {
        &self.domain
    }

    /// Leaves the middleware and gives the domain back.
    #[must_use]
    pub fn leave(self) -> Domain {
        drop(self.node);
        self.domain
    }

    /// Gives the domain back without touching the middleware's files: for a domain whose files may
    /// be corrupt. They are removed with the domain.
    #[must_use]
    pub fn abandon(self) -> Domain {
        core::mem::forget(self.node);
        self.domain
    }

    /// Makes every topic and doorbell of the domain. The stack exists as long as the result.
    ///
    /// # Errors
    /// [`StartError::System`] naming the topic.
    pub fn create_topics(&self) -> Result<Topics, StartError> {
        self.create_topics_but("")
    }

    /// [`Self::create_topics`], but the topic called `foreign` has the schema hash of no contract: to
    /// see what a service does that meets another contract than its own.
    ///
    /// # Errors
    /// As [`Self::create_topics`].
    pub fn create_topics_but(&self, foreign: &str) -> Result<Topics, StartError> {
        let mut creator = Creator {
            peer: self,
            foreign,
            topics: Topics::default(),
        };
        visit_topics(&mut creator)?;
        for role in Role::SERVICES {
            let name = role.doorbell();
            let bell = self
                .node
                .service_builder(&service_name(&name)?)
                .event()
                .max_notifiers(RINGERS_MAX)
                .max_listeners(WRITERS_MAX)
                .max_nodes(NODES_MAX)
                .event_id_max_value(EVENT_MAX)
                .create()
                .map_err(|error| StartError::system(format!("making {name}"), error))?;
            creator.topics.held.push(Box::new(bell));
        }
        Ok(creator.topics)
    }

    pub(crate) fn node(&self) -> &Node<ipc::Service> {
        &self.node
    }

    /// Opens the writer of a topic with slices of up to `len` items.
    ///
    /// # Errors
    /// [`StartError::Contract`] when the topic is another than this build knows,
    /// [`StartError::Memory`] when its memory does not fit.
    pub fn writer<T: Topic>(&self, len: usize) -> Result<Writer<T>, StartError> {
        self.writer_on::<T>(T::ROW, len)
    }

    /// [`Self::writer`] on a row that shares its type with others, such as a heartbeat.
    ///
    /// # Errors
    /// As [`Self::writer`].
    pub(crate) fn writer_on<T: Topic>(
        &self,
        row: &'static TopicRow,
        len: usize,
    ) -> Result<Writer<T>, StartError> {
        if len > row.len_max {
            return Err(StartError::Usage(format!(
                "topic {}: {len} items asked, the contract allows {}",
                row.name, row.len_max
            )));
        }
        let layout = Layout::of::<T>();
        let factory = self.open(row, &layout)?;
        let sender = self.sender(row, &factory, &layout, len)?;
        Ok(Writer::new(row, sender, factory, self.role, self.epoch))
    }

    /// Opens a reader that keeps the newest message of a latest or latched topic.
    ///
    /// # Errors
    /// [`StartError::Contract`] when the topic is another than this build knows.
    pub fn latest<T: Topic>(&self) -> Result<Latest<T>, StartError> {
        self.latest_on::<T>(T::ROW)
    }

    /// [`Self::latest`] on a row that shares its type with others, such as a heartbeat.
    ///
    /// # Errors
    /// As [`Self::latest`].
    pub fn latest_on<T: Topic>(&self, row: &'static TopicRow) -> Result<Latest<T>, StartError> {
        Ok(Latest::new(row, self.receiver(row, &Layout::of::<T>())?))
    }

    /// Opens a reader that sees every message in order. Taps read latest topics so, too.
    ///
    /// # Errors
    /// [`StartError::Contract`] when the topic is another than this build knows.
    pub fn stream<T: Topic>(&self) -> Result<Stream<T>, StartError> {
        self.stream_on::<T>(T::ROW)
    }

    /// [`Self::stream`] on a row that shares its type with others, such as a heartbeat.
    ///
    /// # Errors
    /// As [`Self::stream`].
    pub fn stream_on<T: Topic>(&self, row: &'static TopicRow) -> Result<Stream<T>, StartError> {
        Ok(Stream::new(row, self.receiver(row, &Layout::of::<T>())?))
    }

    /// How many writers and readers a topic has now.
    ///
    /// # Errors
    /// As [`Self::latest`].
    pub fn ports<T: Topic>(&self, row: &'static TopicRow) -> Result<[usize; 2], StartError> {
        let factory = self.open(row, &Layout::of::<T>())?;
        Ok(middleware::ports(&factory))
    }

    /// How many writers and readers `run/spans` has now.
    ///
    /// # Errors
    /// As [`Self::latest`].
    pub fn span_ports(&self) -> Result<[usize; 2], StartError> {
        let factory = self.open(&SPANS, &Layout::of_spans())?;
        Ok(middleware::ports(&factory))
    }

    /// Opens the writer of `run/spans`.
    ///
    /// # Errors
    /// As [`Self::writer`].
    pub fn span_writer(&self) -> Result<SpanWriter, StartError> {
        let layout = Layout::of_spans();
        let factory = self.open(&SPANS, &layout)?;
        Ok(SpanWriter::new(self.sender(&SPANS, &factory, &layout, 1)?))
    }

    /// Opens a reader of `run/spans`.
    ///
    /// # Errors
    /// As [`Self::latest`].
    pub fn span_reader(&self) -> Result<SpanReader, StartError> {
        let receiver = self.receiver(&SPANS, &Layout::of_spans())?;
        Ok(SpanReader::new(receiver))
    }

    /// Opens a reader that sees every message of a topic as it is.
    ///
    /// # Errors
    /// As [`Self::latest`].
    pub fn raw_on<T: Topic>(&self, row: &'static TopicRow) -> Result<RawReader, StartError> {
        Ok(RawReader::new(self.receiver(row, &Layout::of::<T>())?))
    }

    /// Opens a writer that sends messages of up to `len` items as they are, whoever their header names.
    ///
    /// # Errors
    /// As [`Self::writer`].
    pub fn raw_writer_on<T: Topic>(
        &self,
        row: &'static TopicRow,
        len: usize,
    ) -> Result<RawWriter, StartError> {
        let layout = Layout::of::<T>();
        let factory = self.open(row, &layout)?;
        let sender = self.sender(row, &factory, &layout, len.min(row.len_max))?;
        Ok(RawWriter::new(sender, factory, row.item_bytes))
    }

    /// [`Self::raw_writer_on`] for `run/spans`.
    ///
    /// # Errors
    /// As [`Self::writer`].
    pub fn raw_span_writer(&self) -> Result<RawWriter, StartError> {
        let layout = Layout::of_spans();
        let factory = self.open(&SPANS, &layout)?;
        let sender = self.sender(&SPANS, &factory, &layout, 1)?;
        Ok(RawWriter::new(sender, factory, SPANS.item_bytes))
    }

    /// [`Self::raw_on`] for `run/spans`.
    ///
    /// # Errors
    /// As [`Self::latest`].
    pub fn raw_spans(&self) -> Result<RawReader, StartError> {
        let receiver = self.receiver(&SPANS, &Layout::of_spans())?;
        Ok(RawReader::new(receiver))
    }

    pub(crate) fn sender(
        &self,
        row: &TopicRow,
        factory: &Factory,
        layout: &Layout,
        len: usize,
    ) -> Result<Sender, StartError> {
        memory::check(row.segment_bytes(len) as u64)?;
        let pool = row.pool();
        let publisher = factory
            .publisher_builder()
            .initial_max_slice_len(len.max(1))
            .max_loaned_samples(1)
            .override_sample_preallocation(move |worst| worst.min(pool))
            .create()
            .map_err(|error| StartError::system(format!("writing {}", row.name), error))?;
        memory::reserve(self.domain.prefix(), publisher.id().value(), row.name)?;
        Ok(Sender::new(publisher, layout))
    }

    fn receiver(&self, row: &'static TopicRow, layout: &Layout) -> Result<Receiver, StartError> {
        self.receiver_of(row, &*self.open(row, layout)?, layout)
    }

    pub(crate) fn receiver_of(
        &self,
        row: &'static TopicRow,
        factory: &Factory,
        layout: &Layout,
    ) -> Result<Receiver, StartError> {
        let buffer = if self.tap {
            row.buffer()
        } else {
            row.service_buffer()
        };
        let subscriber = factory
            .subscriber_builder()
            .buffer_size(buffer)
            .create()
            .map_err(|error| read_error(row, error))?;
        Ok(Receiver::new(subscriber, row, layout))
    }

    fn open(&self, row: &'static TopicRow, layout: &Layout) -> Result<Erased<Factory>, StartError> {
        let verifier = verifier(row)?;
        retry(|| {
            middleware::topic(&self.node, &service_name(row.name)?, layout)
                .open_with_attributes(&verifier)
                .map(Erased::new)
                .map_err(|error| open_error(row.name, error))
        })
    }
}

struct Creator<'a> {
    peer: &'a Peer,
    /// Name of the topic that gets another schema hash.
    foreign: &'a str,
    topics: Topics,
}

impl Creator<'_> {
    fn create(&mut self, row: &'static TopicRow, layout: &Layout) -> Result<(), StartError> {
        let attributes = specifier(row, self.foreign)?;
        let factory = builder(self.peer, row, layout)?
            .create_with_attributes(&attributes)
            .map_err(|error| StartError::system(format!("making topic {}", row.name), error))?;
        self.topics.held.push(Box::new(factory));
        Ok(())
    }
}

impl TopicVisitor for Creator<'_> {
    type Error = StartError;

    fn topic<T: Topic>(&mut self, row: &'static TopicRow) -> Result<(), StartError> {
        self.create(row, &Layout::of::<T>())
    }

    fn records(&mut self, row: &'static TopicRow) -> Result<(), StartError> {
        self.create(row, &Layout::of_spans())
    }
}

/// Builder of a topic that does not exist yet.
pub(crate) fn builder(
    peer: &Peer,
    row: &TopicRow,
    layout: &Layout,
) -> Result<TopicBuilder, StartError> {
    let builder = middleware::topic(&peer.node, &service_name(row.name)?, layout)
        .history_size(row.history())
        .subscriber_max_buffer_size(row.buffer())
        .subscriber_max_borrowed_samples(row.borrowed())
        .enable_safe_overflow(true)
        .max_publishers(row.writers_max())
        .max_subscribers(READERS_MAX)
        .max_nodes(NODES_MAX);
    Ok(builder)
}

pub(crate) fn service_name(name: &str) -> Result<ServiceName, StartError> {
    ServiceName::new(name)
        .map_err(|error| StartError::system(format!("service name {name}"), error))
}

/// Name and value of the attribute with which a topic's layout is told apart.
fn schema_attribute(schema: u64) -> Result<(AttributeKey, AttributeValue), StartError> {
    let failed = |error| StartError::system("schema attribute", format!("{error:?}"));
    let key = AttributeKey::try_from(SCHEMA_ATTRIBUTE).map_err(failed)?;
    let value = AttributeValue::try_from(format!("{schema:016x}").as_str()).map_err(failed)?;
    Ok((key, value))
}

fn specifier(row: &TopicRow, foreign: &str) -> Result<AttributeSpecifier, StartError> {
    let schema = if row.name == foreign {
        !row.schema
    } else {
        row.schema
    };
    let (key, value) = schema_attribute(schema)?;
    AttributeSpecifier::new()
        .define(&key, &value)
        .map_err(|error| StartError::system("schema attribute", format!("{error:?}")))
}

pub(crate) fn verifier(row: &TopicRow) -> Result<AttributeVerifier, StartError> {
    let (key, value) = schema_attribute(row.schema)?;
    AttributeVerifier::new()
        .require(&key, &value)
        .map_err(|error| StartError::system("schema attribute", format!("{error:?}")))
}

/// Opening may meet a cleanup that is under way; that passes.
pub(crate) fn retry<R>(mut open: impl FnMut() -> Result<R, StartError>) -> Result<R, StartError> {
    let mut last = open();
    for _ in 0..20 {
        match last {
            Err(StartError::System { .. } | StartError::Full { .. }) => {
                std::thread::sleep(core::time::Duration::from_millis(5));
                last = open();
            }
            settled => return settled,
        }
    }
    last
}

fn read_error(row: &TopicRow, error: SubscriberCreateError) -> StartError {
    let what = format!("reading {}", row.name);
    match error {
        SubscriberCreateError::ExceedsMaxSupportedSubscribers => StartError::Full {
            what,
            places: READERS_MAX,
        },
        other => StartError::system(what, other),
    }
}

pub(crate) fn open_error(topic: &str, error: PublishSubscribeOpenError) -> StartError {
    use PublishSubscribeOpenError as E;
    let contract = |problem: &str| StartError::Contract {
        topic: topic.to_owned(),
        problem: problem.to_owned(),
    };
    match error {
        E::IncompatibleTypes => contract("its messages have another type than this build knows"),
        E::IncompatibleAttributes => {
            contract("its messages have other fields than this build knows (schema hash differs)")
        }
        E::DoesNotExist => contract("does not exist in this domain"),
        E::VersionMismatch => contract("made by another version of the middleware"),
        E::ExceedsMaxNumberOfNodes => StartError::Full {
            what: format!("opening topic {topic}"),
            places: NODES_MAX,
        },
        other => StartError::system(format!("opening topic {topic}"), format!("{other:?}")),
    }
}

//! The middleware's publish-subscribe ports, on the bytes of messages.
//!
//! Ports that are generic over the message would be compiled again in every service, which is most of
//! the build of a small one. Here they are compiled once: the types of a topic are values ([`Layout`]),
//! and destructors of the middleware are called through a vtable ([`Erased`]).

use crate::damage;
use core::any::Any;
use core::fmt;
use core::marker::PhantomData;
use core::mem::{ManuallyDrop, MaybeUninit};
use core::ops::Deref;
use iceoryx2::node::Node;
use iceoryx2::port;
use iceoryx2::port::update_connections::UpdateConnections;
use iceoryx2::prelude::ipc;
use iceoryx2::service::builder::publish_subscribe::Builder;
use iceoryx2::service::marker::{CustomHeaderMarker, CustomPayloadMarker};
use iceoryx2::service::port_factory::PortFactory as _;
use iceoryx2::service::port_factory::publish_subscribe::PortFactory;
use iceoryx2::service::service_name::ServiceName;
use iceoryx2::service::static_config::message_type_details::{TypeDetail, TypeVariant};
use zeronav_msgs::span::Span;
use zeronav_msgs::topics::{Topic, TopicRow};

/// The middleware's builder of a topic.
pub(crate) type TopicBuilder = Builder<[CustomPayloadMarker], CustomHeaderMarker, ipc::Service>;

/// What a topic's ports are made from.
pub(crate) type Factory = PortFactory<ipc::Service, [CustomPayloadMarker], CustomHeaderMarker>;

type Publisher =
    port::publisher::Publisher<ipc::Service, [CustomPayloadMarker], CustomHeaderMarker>;

type Subscriber =
    port::subscriber::Subscriber<ipc::Service, [CustomPayloadMarker], CustomHeaderMarker>;

/// A value of the middleware whose destructor the crates above do not compile.
pub(crate) struct Erased<T> {
    value: Box<dyn Any>,
    of: PhantomData<fn() -> T>,
}

impl<T: 'static> Erased<T> {
    pub(crate) fn new(value: T) -> Self {
        Self {
            value: Box::new(value),
            of: PhantomData,
        }
    }
}

impl<T: 'static> Deref for Erased<T> {
    type Target = T;

    fn deref(&self) -> &T {
        let value = self.value.downcast_ref();
        value.expect("made from this type")
    }
}

impl<T> fmt::Debug for Erased<T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(core::any::type_name::<T>())
    }
}

/// The types of a topic's messages, as the middleware compares them: name, size and alignment.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Layout {
    envelope: TypeDetail,
    item: TypeDetail,
}

impl Layout {
    pub(crate) fn of<T: Topic>() -> Self {
        Self {
            envelope: TypeDetail::new::<T::Envelope>(TypeVariant::FixedSize),
            item: TypeDetail::new::<T::Item>(TypeVariant::Dynamic),
        }
    }

    /// Records have no envelope, and one item each.
    pub(crate) fn of_spans() -> Self {
        Self {
            envelope: TypeDetail::new::<()>(TypeVariant::FixedSize),
            item: TypeDetail::new::<Span>(TypeVariant::FixedSize),
        }
    }
}

/// Builder of the topic `name`, whose messages have this layout.
#[allow(
    unsafe_code,
    reason = "the middleware takes types that are values only so"
)]
pub(crate) fn topic(
    node: &Node<ipc::Service>,
    name: &ServiceName,
    layout: &Layout,
) -> TopicBuilder {
    let builder = node
        .service_builder(name)
        .publish_subscribe::<[CustomPayloadMarker]>()
        .user_header::<CustomHeaderMarker>();
    // SAFETY: the layout is that of types that may lie in shared memory, and every port of the result
    // reads and writes bytes of just these sizes.
    unsafe {
        builder
            .__internal_set_payload_type_details(&layout.item)
            .__internal_set_user_header_type_details(&layout.envelope)
    }
}

/// How many writers and readers a topic has now.
pub(crate) fn ports(factory: &Factory) -> [usize; 2] {
    let ports = factory.dynamic_config();
    [ports.number_of_publishers(), ports.number_of_subscribers()]
}

/// Why a message was not sent.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Unsent {
    /// No memory is free.
    NoMemory,
    /// The middleware did not take it.
    Rejected,
}

/// The writing end.
#[derive(Debug)]
pub(crate) struct Sender {
    port: Erased<Publisher>,
    envelope_bytes: usize,
}

impl Sender {
    pub(crate) fn new(port: Publisher, layout: &Layout) -> Self {
        Self {
            port: Erased::new(port),
            envelope_bytes: layout.envelope.size(),
        }
    }

    /// Longest slice that fits. [items]
    pub(crate) fn len_max(&self) -> usize {
        self.port.initial_max_slice_len()
    }

    /// Sends a message of `len` items, one on a topic of records. `fill` writes envelope and items, which
    /// are zero before, in place.
    ///
    /// # Errors
    /// [`Unsent::NoMemory`] before `fill` is called, [`Unsent::Rejected`] after.
    #[allow(
        unsafe_code,
        reason = "the middleware lends memory of types that are values only so"
    )]
    pub(crate) fn send(
        &self,
        len: usize,
        fill: &mut dyn FnMut(&mut [u8], &mut [u8]),
    ) -> Result<(), Unsent> {
        // SAFETY: any number of items may be lent of a slice, and one of a record.
        let lent = unsafe { self.port.loan_custom_payload(len) };
        let mut lent = lent.map_err(|_| Unsent::NoMemory)?;
        let envelope: *mut CustomHeaderMarker = lent.user_header_mut();
        let items: *mut [MaybeUninit<CustomPayloadMarker>] = lent.payload_mut();
        // SAFETY: both lie in the memory that is lent, one behind the other; the envelope has the size
        // of its layout, the items that of the slice. Nobody else has them before they are sent, and
        // `lent` is not touched while they are borrowed. They are written before they are read.
        let lent = unsafe {
            let envelope = envelope.cast::<u8>();
            envelope.write_bytes(0, self.envelope_bytes);
            let envelope = core::slice::from_raw_parts_mut(envelope, self.envelope_bytes);
            let bytes = items.len();
            let items = items.cast::<u8>();
            items.write_bytes(0, bytes);
            fill(envelope, core::slice::from_raw_parts_mut(items, bytes));
            lent.assume_init()
        };
        lent.send().map(|_| ()).map_err(|_| Unsent::Rejected)
    }

    /// Brings the last message of a latched topic to readers that joined since.
    pub(crate) fn refresh(&self) {
        let _ = self.port.update_connections();
    }
}

/// The reading end.
#[derive(Debug)]
pub(crate) struct Receiver {
    port: Erased<Subscriber>,
    number: usize,
    envelope_bytes: usize,
}

impl Receiver {
    pub(crate) fn new(port: Subscriber, row: &'static TopicRow, layout: &Layout) -> Self {
        damage::will_read(row);
        Self {
            number: row.number,
            port: Erased::new(port),
            envelope_bytes: layout.envelope.size(),
        }
    }

    /// True when something has come that [`Self::receive`] has not returned yet.
    pub(crate) fn waits(&self) -> bool {
        self.port.has_samples().unwrap_or(false)
    }

    /// The next message.
    pub(crate) fn receive(&self) -> Option<Sample> {
        let receive = || self.port.receive().ok().flatten();
        let sample = damage::reading(self.number, receive)?;
        Some(Sample {
            sample: ManuallyDrop::new(sample),
            envelope_bytes: self.envelope_bytes,
        })
    }
}

/// A message in shared memory.
pub(crate) struct Sample {
    sample: ManuallyDrop<
        iceoryx2::sample::Sample<ipc::Service, [CustomPayloadMarker], CustomHeaderMarker>,
    >,
    envelope_bytes: usize,
}

impl Sample {
    /// Header and fixed fields.
    #[allow(
        unsafe_code,
        reason = "the middleware hands out what is no type only so"
    )]
    pub(crate) fn envelope(&self) -> &[u8] {
        let envelope: *const CustomHeaderMarker = self.sample.user_header();
        // SAFETY: the envelope has the size of its layout, which the topic has, or it had not been
        // opened; the memory stays as long as the sample.
        unsafe { core::slice::from_raw_parts(envelope.cast(), self.envelope_bytes) }
    }

    /// The slice.
    #[allow(
        unsafe_code,
        reason = "the middleware hands out what is no type only so"
    )]
    pub(crate) fn items(&self) -> &[u8] {
        let items = self.sample.payload();
        // SAFETY: the marker is one byte, and the memory stays as long as the sample.
        unsafe { core::slice::from_raw_parts(items.as_ptr().cast(), items.len()) }
    }
}

impl Drop for Sample {
    #[allow(
        unsafe_code,
        reason = "what is dropped by itself is compiled in every crate above"
    )]
    fn drop(&mut self) {
        // SAFETY: dropped here alone, once.
        unsafe { ManuallyDrop::drop(&mut self.sample) }
    }
}

//! Topics of a user's own: `user/NAME`, see [`zeronav_msgs::user`]. Whoever opens one first makes it, and it
//! exists as long as somebody has it open.

use crate::error::StartError;
use crate::link::View;
use crate::middleware::{self, Erased, Factory, Layout, Receiver, Sample};
use crate::peer::{self, Peer};
use crate::raw::{RawReader, RawWriter};
use crate::writer::{Draft, Sent, Writer};
use bytemuck::from_bytes;
use iceoryx2::prelude::{
    AttributeVerifier, CallbackProgression, SemanticString, Service as _, ipc,
};
use iceoryx2::service::attribute::{AttributeKey, AttributeSet, AttributeValue};
use iceoryx2::service::builder::publish_subscribe::PublishSubscribeOpenOrCreateError;
use iceoryx2::service::port_factory::PortFactory as _;
use std::path::PathBuf;
use std::time::SystemTime;
use zeronav_msgs::message::Refusal;
use zeronav_msgs::topics::{Envelope, TopicRow, decode};
use zeronav_msgs::user::{
    self, Form, USER_BYTES_MAX, UserEnvelope, UserError, UserMessage, UserTopic,
};

/// Name of the attribute that carries the text of the form.
const FORM_ATTRIBUTE: &str = "form";

/// Most topics of users that are listed.
const LISTED_MAX: usize = 256;

impl From<UserError> for StartError {
    fn from(error: UserError) -> Self {
        Self::Usage(error.to_string())
    }
}

/// The writing end of a user's own topic.
#[derive(Debug)]
pub struct UserWriter {
    writer: Writer<UserTopic>,
    meta: UserMessage,
}

impl UserWriter {
    /// Sends one message; `None` when it is longer than the writer was opened for or finds no memory, as
    /// [`Writer::publish`]. What is made from no message of the stack has the default draft.
    pub fn publish(&mut self, draft: &Draft, bytes: &[u8]) -> Option<Sent> {
        self.writer.publish(draft, self.meta, bytes)
    }

    /// True while the topic has a reader.
    #[must_use]
    pub fn is_read(&self) -> bool {
        self.writer.is_read()
    }
}

/// The reading end of a user's own topic: sees every message in order, whoever wrote it.
#[derive(Debug)]
pub struct UserReader {
    row: &'static TopicRow,
    receiver: Receiver,
    refused: u64,
    seen: Vec<Refusal>,
}

impl UserReader {
    /// The topic's row.
    #[must_use]
    pub fn row(&self) -> &'static TopicRow {
        self.row
    }

    /// Shows the oldest message that has come to `see`, and gives it back to its writer; `None` when
    /// there is no more.
    pub fn take<R>(&mut self, see: impl FnOnce(View<'_, UserTopic>) -> R) -> Option<R> {
        loop {
            let sample = self.receiver.receive()?;
            let view = view(&sample);
            let envelope: &UserEnvelope = from_bytes(sample.envelope());
            match decode::<UserTopic>(self.row, envelope, view.items) {
                Ok(()) => return Some(see(view)),
                Err(refusal) => self.note(refusal),
            }
        }
    }

    fn note(&mut self, refusal: Refusal) {
        self.refused += 1;
        if !self.seen.contains(&refusal) {
            self.seen.push(refusal);
            tracing::warn!(topic = self.row.name, %refusal, "message refused");
        }
    }

    /// Messages that were rejected.
    #[must_use]
    pub fn refused(&self) -> u64 {
        self.refused
    }
}

fn view(sample: &Sample) -> View<'_, UserTopic> {
    let envelope: &UserEnvelope = from_bytes(sample.envelope());
    View {
        header: envelope.header(),
        meta: envelope.meta(),
        items: sample.items(),
    }
}

/// A topic of a user's own that exists.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Listed {
    /// What stands behind the prefix.
    pub name: String,
    /// What its bytes mean.
    pub form: Form,
}

impl Peer {
    /// Opens the writer of the topic `name` (without the prefix) with messages of up to `bytes_max`.
    ///
    /// # Errors
    /// [`StartError::Usage`] for a name that cannot be, [`StartError::Contract`] when the topic exists with
    /// another form, [`StartError::Memory`] when its memory does not fit.
    pub fn user_writer(
        &self,
        name: &str,
        form: &Form,
        bytes_max: usize,
    ) -> Result<UserWriter, StartError> {
        let row = user::row(name, form)?;
        if bytes_max > USER_BYTES_MAX {
            return Err(StartError::Usage(format!(
                "topic {}: messages of {bytes_max} bytes asked, at most {USER_BYTES_MAX}",
                row.name
            )));
        }
        let layout = Layout::of::<UserTopic>();
        let factory = self.open_user(row, form, &layout)?;
        let sender = self.sender(row, &factory, &layout, bytes_max)?;
        let writer = Writer::new(row, sender, factory, self.role(), self.epoch());
        let meta = UserMessage { form: form.hash() };
        Ok(UserWriter { writer, meta })
    }

    /// Opens a reader of the topic `name` (without the prefix).
    ///
    /// # Errors
    /// As [`Self::user_writer`].
    pub fn user_reader(&self, name: &str, form: &Form) -> Result<UserReader, StartError> {
        let row = user::row(name, form)?;
        let layout = Layout::of::<UserTopic>();
        let factory = self.open_user(row, form, &layout)?;
        Ok(UserReader {
            row,
            receiver: self.receiver_of(row, &factory, &layout)?,
            refused: 0,
            seen: Vec::new(),
        })
    }

    /// Opens a reader that sees every message of the topic `name` (without the prefix) as it is.
    ///
    /// # Errors
    /// As [`Self::user_writer`].
    pub fn raw_user(
        &self,
        name: &str,
        form: &Form,
    ) -> Result<(&'static TopicRow, RawReader), StartError> {
        let row = user::row(name, form)?;
        let layout = Layout::of::<UserTopic>();
        let factory = self.open_user(row, form, &layout)?;
        let receiver = self.receiver_of(row, &factory, &layout)?;
        Ok((row, RawReader::new(receiver)))
    }

    /// Opens a writer of the topic `name` (without the prefix) that sends messages of up to `bytes_max` as they are.
    ///
    /// # Errors
    /// As [`Self::user_writer`].
    pub fn raw_user_writer(
        &self,
        name: &str,
        form: &Form,
        bytes_max: usize,
    ) -> Result<RawWriter, StartError> {
        let row = user::row(name, form)?;
        let layout = Layout::of::<UserTopic>();
        let factory = self.open_user(row, form, &layout)?;
        let sender = self.sender(row, &factory, &layout, bytes_max.min(USER_BYTES_MAX))?;
        Ok(RawWriter::new(sender, factory, 1))
    }

    /// When a topic was last made or removed, by the clock of the files: one that is just being made is listed a moment
    /// later. `None` when that cannot be known.
    #[must_use]
    pub fn topics_changed(&self) -> Option<SystemTime> {
        let config = self.domain().config().ok()?;
        let folder = config.global.service_dir();
        let folder = PathBuf::from(core::str::from_utf8(folder.as_bytes()).ok()?);
        folder.metadata().ok()?.modified().ok()
    }

    /// How many writers and readers a user's own topic has now.
    ///
    /// # Errors
    /// As [`Self::user_reader`].
    pub fn user_ports(&self, name: &str, form: &Form) -> Result<[usize; 2], StartError> {
        let row = user::row(name, form)?;
        let factory = self.open_user(row, form, &Layout::of::<UserTopic>())?;
        Ok(middleware::ports(&factory))
    }

    /// The topics of users that exist in the domain, by name.
    ///
    /// # Errors
    /// [`StartError::System`] when the middleware does not list them.
    pub fn user_topics(&self) -> Result<Vec<Listed>, StartError> {
        let mut listed = Vec::new();
        let config = self.domain().config()?;
        ipc::Service::list(&config, |service| {
            let name = user::name_in(service.static_details.name().as_str());
            let form = form_in(service.static_details.attributes());
            listed.extend(name.zip(form).map(|(name, form)| Listed {
                name: name.to_owned(),
                form,
            }));
            if listed.len() < LISTED_MAX {
                CallbackProgression::Continue
            } else {
                CallbackProgression::Stop
            }
        })
        .map_err(|error| StartError::system("listing topics", format!("{error:?}")))?;
        listed.sort_by(|a, b| a.name.cmp(&b.name));
        Ok(listed)
    }

    fn open_user(
        &self,
        row: &TopicRow,
        form: &Form,
        layout: &Layout,
    ) -> Result<Erased<Factory>, StartError> {
        use PublishSubscribeOpenOrCreateError as E;
        let verifier = verifier(row, form)?;
        peer::retry(|| {
            let opened =
                peer::builder(self, row, layout)?.open_or_create_with_attributes(&verifier);
            opened.map(Erased::new).map_err(|error| match error {
                E::PublishSubscribeOpenError(error) => {
                    self.refusal(row, form, layout, peer::open_error(row.name, error))
                }
                other => {
                    StartError::system(format!("making topic {}", row.name), format!("{other:?}"))
                }
            })
        })
    }

    /// The error, with the form that the topic has when it is another.
    fn refusal(
        &self,
        row: &TopicRow,
        form: &Form,
        layout: &Layout,
        error: StartError,
    ) -> StartError {
        let existing = || {
            let builder = peer::builder(self, row, layout).ok()?;
            form_in(builder.open().ok()?.attributes())
        };
        match (&error, existing()) {
            (StartError::Contract { .. }, Some(other)) if other != *form => StartError::Contract {
                topic: row.name.to_owned(),
                problem: format!(
                    "its form is \"{}\", and this program expects \"{}\": declare the same text in both",
                    other.text(),
                    form.text()
                ),
            },
            _ => error,
        }
    }
}

fn form_attribute(form: &Form) -> Result<(AttributeKey, AttributeValue), StartError> {
    let failed = |error| StartError::system("form attribute", format!("{error:?}"));
    let key = AttributeKey::try_from(FORM_ATTRIBUTE).map_err(failed)?;
    Ok((key, AttributeValue::try_from(form.text()).map_err(failed)?))
}

/// What a topic must have, or gets when it is made.
fn verifier(row: &TopicRow, form: &Form) -> Result<AttributeVerifier, StartError> {
    let (key, value) = form_attribute(form)?;
    peer::verifier(row)?
        .require(&key, &value)
        .map_err(|error| StartError::system("form attribute", format!("{error:?}")))
}

/// The form in the attributes of a topic.
fn form_in(attributes: &AttributeSet) -> Option<Form> {
    let key = AttributeKey::try_from(FORM_ATTRIBUTE).ok()?;
    let value = attributes.key_value(&key, 0)?;
    Form::new(core::str::from_utf8(value.as_bytes()).ok()?).ok()
}

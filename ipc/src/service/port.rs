use iceoryx2::port::notifier::Notifier as EventNotifier;
use iceoryx2::port::publisher::Publisher;
use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::port::update_connections::UpdateConnections;
use iceoryx2::port::{ReceiveError, SendError};
use iceoryx2::prelude::ipc;
use iceoryx2::sample::Sample;

use super::error::SendFailure;
use super::quality::Carried;
use crate::message::CameraFrame;

/// Wakes the listeners of a service.
#[derive(Debug)]
pub struct Notifier {
    notifier: EventNotifier<ipc::Service>,
}

impl Notifier {
    pub(super) const fn new(notifier: EventNotifier<ipc::Service>) -> Self {
        Self { notifier }
    }

    /// Wakes them. A listener that cannot be woken polls a little later, since every wait is
    /// bounded.
    pub fn notify(&self) {
        let _ = self.notifier.notify();
    }
}

/// Sends messages of one type.
#[derive(Debug)]
pub struct Sender<M: Carried> {
    publisher: Publisher<ipc::Service, M, ()>,
    notifier: Notifier,
}

impl<M: Carried> Sender<M> {
    pub(super) const fn new(publisher: Publisher<ipc::Service, M, ()>, notifier: Notifier) -> Self {
        Self {
            publisher,
            notifier,
        }
    }

    /// Sends a message and notifies; returns the number of receivers. Never waits.
    pub fn send(&self, message: &M) -> Result<usize, SendFailure> {
        let receivers = self
            .publisher
            .send_copy(*message)
            .map_err(|error| match error {
                SendError::UnableToDeliver => SendFailure::Full,
                error => SendFailure::Iceoryx(format!("{error:?}")),
            })?;
        self.notifier.notify();
        Ok(receivers)
    }

    /// Sends the history of the service to receivers that have joined since the last message;
    /// iceoryx2 does so only when its publisher acts. Call it a few times per second if messages
    /// are rare.
    pub fn update_connections(&self) {
        // A receiver that cannot be reached gets the next message, or is gone.
        let _ = self.publisher.update_connections();
    }
}

/// Receives messages of one type.
#[derive(Debug)]
pub struct Receiver<M: Carried> {
    subscriber: Subscriber<ipc::Service, M, ()>,
}

impl<M: Carried> Receiver<M> {
    pub(super) const fn new(subscriber: Subscriber<ipc::Service, M, ()>) -> Self {
        Self { subscriber }
    }

    /// The next message, in place; `None` if none has arrived.
    pub fn receive(&self) -> Result<Option<Sample<ipc::Service, M, ()>>, ReceiveError> {
        self.subscriber.receive()
    }

    /// The waiting messages, in the order of each publisher. Ends after a full buffer, so that a
    /// flood of messages cannot block the receiver; what cannot be read now is left for the next
    /// call.
    pub fn waiting(&self) -> impl Iterator<Item = Sample<ipc::Service, M, ()>> {
        let most = M::QUALITY.buffer * M::QUALITY.publishers;
        (0..most).map_while(|_| self.receive().ok().flatten())
    }
}

/// Publishes frames.
#[derive(Debug)]
pub struct FramesOut {
    publisher: Publisher<ipc::Service, [u8], CameraFrame>,
    notifier: Notifier,
}

impl FramesOut {
    pub(super) const fn new(
        publisher: Publisher<ipc::Service, [u8], CameraFrame>,
        notifier: Notifier,
    ) -> Self {
        Self {
            publisher,
            notifier,
        }
    }

    /// Publishes a frame that is written in place, where its readers read it; returns their number.
    ///
    /// * `bytes`: size of the image, seven bytes per pixel: see [`CameraFrame`]
    /// * `write`: writes the image into the given memory, which still holds an earlier frame;
    ///   clearing it would take as long as writing it
    pub fn send(
        &self,
        header: CameraFrame,
        bytes: usize,
        write: impl FnOnce(&mut [u8]),
    ) -> Result<usize, SendFailure> {
        let says = |error: &dyn core::fmt::Debug| SendFailure::Iceoryx(format!("{error:?}"));
        let frame = self
            .publisher
            .loan_slice_uninit(bytes)
            .map_err(|error| says(&error))?;
        // SAFETY: bytes of any value are bytes, and shared memory has been written since it
        // was mapped: with 0 by the system, then by earlier frames.
        let mut frame = unsafe { frame.assume_init() };
        *frame.user_header_mut() = header;
        write(frame.payload_mut());
        let receivers = frame.send().map_err(|error| says(&error))?;
        self.notifier.notify();
        Ok(receivers)
    }
}

/// Receives frames.
#[derive(Debug)]
pub struct Frames {
    subscriber: Subscriber<ipc::Service, [u8], CameraFrame>,
}

impl Frames {
    pub(super) const fn new(subscriber: Subscriber<ipc::Service, [u8], CameraFrame>) -> Self {
        Self { subscriber }
    }

    /// The latest frame, in place; `None` if there is no new one.
    pub fn receive(&self) -> Result<Option<Sample<ipc::Service, [u8], CameraFrame>>, ReceiveError> {
        self.subscriber.receive()
    }
}

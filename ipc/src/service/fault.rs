//! Reduces iceoryx2's many errors on opening a service and creating a port to a few.

use core::fmt::Debug;

use iceoryx2::port::listener::ListenerCreateError;
use iceoryx2::port::notifier::NotifierCreateError;
use iceoryx2::port::publisher::PublisherCreateError;
use iceoryx2::port::subscriber::SubscriberCreateError;
use iceoryx2::service::builder::event::{EventCreateError, EventOpenError, EventOpenOrCreateError};
use iceoryx2::service::builder::publish_subscribe::{
    PublishSubscribeCreateError, PublishSubscribeOpenError, PublishSubscribeOpenOrCreateError,
};
use iceoryx2::service::builder::request_response::{
    RequestResponseCreateError, RequestResponseOpenError, RequestResponseOpenOrCreateError,
};
use iceoryx2::service::port_factory::client::ClientCreateError;
use iceoryx2::service::port_factory::server::ServerCreateError;

/// Why a service was not opened, or no port created.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Fault {
    /// Another process is creating or removing it.
    InFlux,
    OtherVersion,
    OtherUser,
    Full,
    Other(String),
}

fn other(error: impl Debug) -> Fault {
    Fault::Other(format!("{error:?}"))
}

impl From<PublishSubscribeOpenOrCreateError> for Fault {
    fn from(error: PublishSubscribeOpenOrCreateError) -> Self {
        use PublishSubscribeCreateError as Create;
        use PublishSubscribeOpenError as Open;
        use PublishSubscribeOpenOrCreateError as Error;
        match error {
            Error::SystemInFlux
            | Error::PublishSubscribeOpenError(
                Open::DoesNotExist | Open::HangsInCreation | Open::IsMarkedForDestruction,
            )
            | Error::PublishSubscribeCreateError(
                Create::AlreadyExists
                | Create::HangsInCreation
                | Create::IsBeingCreatedByAnotherInstance,
            ) => Self::InFlux,
            Error::PublishSubscribeOpenError(
                Open::IncompatibleTypes
                | Open::IncompatibleMessagingPattern
                | Open::IncompatibleAttributes
                | Open::IncompatibleOverflowBehavior
                | Open::DoesNotSupportRequestedMinBufferSize
                | Open::DoesNotSupportRequestedMinHistorySize
                | Open::DoesNotSupportRequestedAmountOfPublishers
                | Open::DoesNotSupportRequestedAmountOfSubscribers
                | Open::VersionMismatch,
            ) => Self::OtherVersion,
            Error::PublishSubscribeOpenError(Open::InsufficientPermissions)
            | Error::PublishSubscribeCreateError(Create::InsufficientPermissions) => {
                Self::OtherUser
            }
            Error::PublishSubscribeOpenError(Open::ExceedsMaxNumberOfNodes) => Self::Full,
            error => other(error),
        }
    }
}

impl From<RequestResponseOpenOrCreateError> for Fault {
    fn from(error: RequestResponseOpenOrCreateError) -> Self {
        use RequestResponseCreateError as Create;
        use RequestResponseOpenError as Open;
        use RequestResponseOpenOrCreateError as Error;
        match error {
            Error::SystemInFlux
            | Error::RequestResponseOpenError(
                Open::DoesNotExist | Open::HangsInCreation | Open::IsMarkedForDestruction,
            )
            | Error::RequestResponseCreateError(
                Create::AlreadyExists
                | Create::HangsInCreation
                | Create::IsBeingCreatedByAnotherInstance,
            ) => Self::InFlux,
            Error::RequestResponseOpenError(
                Open::IncompatibleRequestOrResponseType
                | Open::IncompatibleMessagingPattern
                | Open::IncompatibleAttributes
                | Open::IncompatibleOverflowBehaviorForRequests
                | Open::IncompatibleOverflowBehaviorForResponses
                | Open::DoesNotSupportRequestedResponseBufferSize
                | Open::DoesNotSupportRequestedAmountOfServers
                | Open::DoesNotSupportRequestedAmountOfClients
                | Open::VersionMismatch,
            ) => Self::OtherVersion,
            Error::RequestResponseOpenError(Open::InsufficientPermissions)
            | Error::RequestResponseCreateError(Create::InsufficientPermissions) => Self::OtherUser,
            Error::RequestResponseOpenError(Open::ExceedsMaxNumberOfNodes) => Self::Full,
            error => other(error),
        }
    }
}

impl From<EventOpenOrCreateError> for Fault {
    fn from(error: EventOpenOrCreateError) -> Self {
        use EventCreateError as Create;
        use EventOpenError as Open;
        use EventOpenOrCreateError as Error;
        match error {
            Error::SystemInFlux
            | Error::EventOpenError(
                Open::DoesNotExist | Open::HangsInCreation | Open::IsMarkedForDestruction,
            )
            | Error::EventCreateError(
                Create::AlreadyExists | Create::IsBeingCreatedByAnotherInstance,
            ) => Self::InFlux,
            Error::EventOpenError(
                Open::IncompatibleMessagingPattern
                | Open::IncompatibleAttributes
                | Open::IncompatibleDeadline
                | Open::DoesNotSupportRequestedAmountOfNotifiers
                | Open::DoesNotSupportRequestedAmountOfListeners
                | Open::VersionMismatch,
            ) => Self::OtherVersion,
            Error::EventOpenError(Open::InsufficientPermissions)
            | Error::EventCreateError(Create::InsufficientPermissions) => Self::OtherUser,
            Error::EventOpenError(Open::ExceedsMaxNumberOfNodes) => Self::Full,
            error => other(error),
        }
    }
}

/// The variant of a port's creation error that means that all slots are taken.
macro_rules! full {
    ($($error:ident :: $full:ident),+ $(,)?) => {$(
        impl From<$error> for Fault {
            fn from(error: $error) -> Self {
                match error {
                    $error::$full => Self::Full,
                    error => other(error),
                }
            }
        }
    )+};
}

full! {
    PublisherCreateError::ExceedsMaxSupportedPublishers,
    SubscriberCreateError::ExceedsMaxSupportedSubscribers,
    ServerCreateError::ExceedsMaxSupportedServers,
    ClientCreateError::ExceedsMaxSupportedClients,
    NotifierCreateError::ExceedsMaxSupportedNotifiers,
    ListenerCreateError::ExceedsMaxSupportedListeners,
}

//! States of the stack, reasons to trip, and what an operator can ask for.

/// What the stack is doing, and whether torque may flow.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum State {
    /// Waiting for a first word from both drives.
    #[default]
    Boot,
    /// Both drives answer and are disabled; waiting for the operator.
    Stopped,
    /// Asked the drives to enable; waiting for both.
    Enabling,
    /// Torque flows.
    Running,
    /// Torque flows, to bring the wheels to rest.
    Stopping,
    /// Something went wrong. Torque stays zero until the operator resets, and
    /// a reset leads to `Stopped`, never to motion.
    Tripped(Reason),
}

/// Why the stack tripped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reason {
    /// A drive sent no feedback for longer than allowed.
    StaleFeedback,
    /// A drive gave no sign of life for longer than allowed.
    HeartbeatLost,
    /// Too many frames of the drives' were damaged.
    DamagedFrames,
    /// A drive's feedback counted further than it can have: it, or somebody
    /// who sends in its name, answers what was not asked.
    CounterJump,
    /// A wheel's angle jumped as no wheel can turn.
    EncoderJump,
    /// A drive reported a fault.
    DriveFault,
    /// A drive left its enabled state unasked.
    DriveDisabled,
    /// A drive did not enable in time.
    EnableTimeout,
    /// A wheel was too far from where it should be.
    FollowingError,
    /// A wheel turned too fast.
    OverSpeed,
    /// The law asked for more torque than the limit for too long.
    TorqueSaturated,
    /// The law asked for a torque that is no number.
    NotFinite,
    /// The wheels did not come to rest in time.
    StopTimeout,
    /// The loop woke up too late.
    LoopOverrun,
    /// The bus went away, or takes no frames.
    BusLost,
    /// The interface's controller went off the bus.
    BusOff,
    /// The operator asked for an emergency stop.
    OperatorStop,
}

/// What the operator can ask for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Operator {
    /// Enable the drives and run the path from its beginning.
    Enable,
    /// Brake to rest, then disable the drives: a stop of category 1
    /// (IEC 60204-1).
    Stop,
    /// Zero torque at once, and a trip: a stop of category 0.
    EmergencyStop,
    /// Acknowledge a trip; motion needs a new `Enable`.
    Reset,
}

impl Operator {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Enable, Self::Stop, Self::EmergencyStop, Self::Reset];

    /// A word for configurations and logs.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Enable => "enable",
            Self::Stop => "stop",
            Self::EmergencyStop => "emergency-stop",
            Self::Reset => "reset",
        }
    }
}

impl State {
    /// A number for logs: 0 boot, 1 stopped, 2 enabling, 3 running,
    /// 4 stopping, 10 and up tripped, one number a reason.
    pub const fn code(self) -> u8 {
        match self {
            Self::Boot => 0,
            Self::Stopped => 1,
            Self::Enabling => 2,
            Self::Running => 3,
            Self::Stopping => 4,
            Self::Tripped(reason) => 10 + reason as u8,
        }
    }

    /// A word for logs.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Boot => "boot",
            Self::Stopped => "stopped",
            Self::Enabling => "enabling",
            Self::Running => "running",
            Self::Stopping => "stopping",
            Self::Tripped(_) => "tripped",
        }
    }

    /// A sentence for people.
    pub const fn text(self) -> &'static str {
        match self {
            Self::Boot => "waiting for both drives to answer",
            Self::Stopped => "stopped: both drives answer, no torque",
            Self::Enabling => "waiting for both drives to enable",
            Self::Running => "running",
            Self::Stopping => "braking to rest",
            Self::Tripped(reason) => reason.text(),
        }
    }

    /// Whether the drives are, or are about to be, in motion: what can trip.
    pub const fn is_armed(self) -> bool {
        matches!(self, Self::Enabling | Self::Running | Self::Stopping)
    }

    /// Whether torque may flow.
    pub const fn lets_torque_flow(self) -> bool {
        matches!(self, Self::Running | Self::Stopping)
    }
}

impl Reason {
    /// All of them, in the order of their numbers.
    pub const ALL: [Self; 17] = [
        Self::StaleFeedback,
        Self::HeartbeatLost,
        Self::DamagedFrames,
        Self::CounterJump,
        Self::EncoderJump,
        Self::DriveFault,
        Self::DriveDisabled,
        Self::EnableTimeout,
        Self::FollowingError,
        Self::OverSpeed,
        Self::TorqueSaturated,
        Self::NotFinite,
        Self::StopTimeout,
        Self::LoopOverrun,
        Self::BusLost,
        Self::BusOff,
        Self::OperatorStop,
    ];

    /// A word for configurations.
    pub const fn name(self) -> &'static str {
        match self {
            Self::StaleFeedback => "stale-feedback",
            Self::HeartbeatLost => "heartbeat-lost",
            Self::DamagedFrames => "damaged-frames",
            Self::CounterJump => "counter-jump",
            Self::EncoderJump => "encoder-jump",
            Self::DriveFault => "drive-fault",
            Self::DriveDisabled => "drive-disabled",
            Self::EnableTimeout => "enable-timeout",
            Self::FollowingError => "following-error",
            Self::OverSpeed => "over-speed",
            Self::TorqueSaturated => "torque-saturated",
            Self::NotFinite => "not-finite",
            Self::StopTimeout => "stop-timeout",
            Self::LoopOverrun => "loop-overrun",
            Self::BusLost => "bus-lost",
            Self::BusOff => "bus-off",
            Self::OperatorStop => "operator-stop",
        }
    }

    /// A sentence for people.
    pub const fn text(self) -> &'static str {
        match self {
            Self::StaleFeedback => "tripped: a drive sent no feedback for too long",
            Self::HeartbeatLost => "tripped: a drive gave no sign of life for too long",
            Self::DamagedFrames => "tripped: too many frames of the drives were damaged",
            Self::CounterJump => "tripped: a drive's feedback counted further than it was asked to",
            Self::EncoderJump => "tripped: an encoder jumped as no wheel can turn",
            Self::DriveFault => "tripped: a drive reported a fault",
            Self::DriveDisabled => "tripped: a drive left its enabled state unasked",
            Self::EnableTimeout => "tripped: a drive did not enable in time",
            Self::FollowingError => "tripped: a wheel was too far from where it should be",
            Self::OverSpeed => "tripped: a wheel turned too fast",
            Self::TorqueSaturated => "tripped: the control law asked for more than the torque limit for too long",
            Self::NotFinite => "tripped: the control law asked for a torque that is no number",
            Self::StopTimeout => "tripped: the wheels did not come to rest in time",
            Self::LoopOverrun => "tripped: the loop woke up too late",
            Self::BusLost => "tripped: the bus went away, or takes no frames",
            Self::BusOff => "tripped: the interface's controller went off the bus",
            Self::OperatorStop => "tripped: the operator asked for an emergency stop",
        }
    }

    /// The key of `[safety]` that sets its limit; none where there is nothing
    /// to be lenient about.
    pub const fn limit_key(self) -> Option<&'static str> {
        match self {
            Self::StaleFeedback => Some("feedback_timeout_periods"),
            Self::HeartbeatLost => Some("heartbeat_timeout_s"),
            Self::DamagedFrames => Some("damaged_frames"),
            Self::EncoderJump => Some("encoder_jump_rad"),
            Self::EnableTimeout => Some("enable_timeout_s"),
            Self::FollowingError => Some("following_error_rad"),
            Self::OverSpeed => Some("wheel_speed_limit_rad_s"),
            Self::TorqueSaturated => Some("saturation_timeout_s"),
            Self::StopTimeout => Some("stop_timeout_s"),
            Self::LoopOverrun => Some("overrun_periods"),
            Self::CounterJump
            | Self::DriveFault
            | Self::DriveDisabled
            | Self::NotFinite
            | Self::BusLost
            | Self::BusOff
            | Self::OperatorStop => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const OTHERS: [State; 5] = [State::Boot, State::Stopped, State::Enabling, State::Running, State::Stopping];

    #[test]
    fn every_state_has_a_number_of_its_own() {
        let others = OTHERS.map(State::code);
        assert_eq!(others, [0, 1, 2, 3, 4]);
        let trips = Reason::ALL.map(|reason| State::Tripped(reason).code());
        assert_eq!(trips.to_vec(), (10..10 + Reason::ALL.len() as u8).collect::<Vec<_>>());
    }

    #[test]
    fn every_state_has_a_name_and_every_reason_a_sentence_and_a_limit_of_its_own() {
        assert_eq!(OTHERS.map(State::name), ["boot", "stopped", "enabling", "running", "stopping"]);
        for reason in Reason::ALL {
            let state = State::Tripped(reason);
            assert_eq!(state.name(), "tripped");
            assert!(state.text().starts_with("tripped: "), "{}", state.text());
            let same = |other: &&Reason| other.text() == reason.text();
            assert_eq!(Reason::ALL.iter().filter(same).count(), 1, "{}", reason.text());
            let shares = |other: &&Reason| other.limit_key() == reason.limit_key();
            assert!(reason.limit_key().is_none() || Reason::ALL.iter().filter(shares).count() == 1);
        }
        let keys: Vec<&str> = Reason::ALL.into_iter().filter_map(Reason::limit_key).collect();
        assert!(keys.len() == 10 && keys.contains(&"wheel_speed_limit_rad_s"), "{keys:?}");
        assert_eq!(State::Stopping.text(), "braking to rest");
    }

    #[test]
    fn torque_flows_while_running_and_braking_only() {
        assert_eq!(OTHERS.map(State::lets_torque_flow), [false, false, false, true, true]);
        assert_eq!(OTHERS.map(State::is_armed), [false, false, true, true, true]);
        for reason in Reason::ALL {
            let state = State::Tripped(reason);
            assert!(!state.lets_torque_flow() && !state.is_armed());
        }
    }
}

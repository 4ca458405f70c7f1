"""The compiled loop of motions with contacts, from event to event."""

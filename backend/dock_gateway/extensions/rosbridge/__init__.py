"""The rosbridge v2 protocol: roslib, roslibpy and other clients of rosbridge use the gateway as they are."""

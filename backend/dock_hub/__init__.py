"""The hub: one dashboard, one API and one set of rights for many sites. No ROS."""

"""Any car's messages, CAN frames and tables as the topics of this graph, by a signal map."""

// Indifferent: walks the stations and takes no notice of the gantry.

{ include("patrol.asl") }

export class ServerLibrary {} export class ServerStore {}
